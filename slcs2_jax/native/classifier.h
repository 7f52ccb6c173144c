// The rule-set classifier: match, learn, choose. See policy/classifier.py, qlearning.py and grasp.py.
#pragma once
#include "mind.h"
#include "randomness.h"

namespace slcs2 {

constexpr uint32_t ACTION_BITS = 0xFF;

// The greatest quality in the match set, 0 if it is empty. Zeros count as positive: which comes first must not matter.
inline float best_ahead(const Mind& mind) {
  Floats best = all(-INFINITE);
  for (int r = 0; r < mind.sizes->rules; r += LANES) {
    const Floats quality = load<Floats>(mind.matched + r);
    best = quality > best ? quality : best;
  }
  const float most = greatest(best);
  return most > -INFINITE ? most + 0.0f : 0.0f;
}

struct Range {
  float best, worst;  // of the qualities in the match set; -infinite and infinite if it is empty
};

inline Range quality_range(const Mind& mind) {
  Floats best = all(-INFINITE), worst = all(INFINITE);
  for (int r = 0; r < mind.sizes->rules; r += LANES) {
    const Floats quality = load<Floats>(mind.matched + r);
    best = quality > best ? quality : best, worst = quality < worst ? quality : worst;
  }
  return {greatest(best) + 0.0f, -greatest(-worst) + 0.0f};
}

// Q-learning over the last action set once the next match set is known (paper, quality and error equations):
// q <- (1 - alpha) q + alpha (rho + beta max q ahead); error <- (1 - alpha) error + alpha |rho - q|, q before the update.
// Counts the usage of the set, too.
inline void learn(Mind& mind, const Bits* members, float reward, float ahead, float alpha, float beta) {
  const float target = alpha * (reward + beta * ahead), rest = 1.0f - alpha;
  for_each(members, mind.words, [&](int r) {
    const float before = mind.quality[r];
    mind.error[r] = alpha * std::fabs(reward - before) + rest * mind.error[r];
    mind.quality[r] = target + rest * before;
    mind.usage[r]++;
    if (mind.match[r / 64] >> (r % 64) & 1) mind.matched[r] = mind.quality[r];
  });
}

// The tickets of some rules of the restricted candidate list, 0 for the others: uniform words whose low bits carry the
// action, so that one maximum both draws the rule and tells what it does.
inline Words tickets(const Mind& mind, int first, const uint32_t* names, const Stream<uint32_t>& lots, Range range,
                     float reach) {
  const Words low = lots.low ^ load<Words>(names + first);
  const Words lot = second_round(first_round(low) + lots.high);
  const Mask listed = range.best - load<Floats>(mind.matched + first) <= reach;
  return ((lot & ~ACTION_BITS) | load<Words>(mind.action + first)) & (Words)listed;
}

// The action of a rule drawn uniformly from those of the match set with q >= q_max - alpha_grasp (q_max - q_min) (paper,
// GRASP equation); NO_ACTION if no rule holds. names: the golden multiples of the rules' numbers in the whole swarm.
inline int choose(const Mind& mind, Range range, const uint32_t* names, float alpha_grasp,
                  const Stream<uint32_t>& lots) {
  if (!(range.best > -INFINITE)) return NO_ACTION;
  Words winner = all(0u);
  const float reach = alpha_grasp * (range.best - range.worst);
  for (int r = 0; r < mind.sizes->rules; r += LANES) {
    const Words ticket = tickets(mind, r, names, lots, range, reach);
    winner = ticket > winner ? ticket : winner;
  }
  return (int)(greatest(winner) & ACTION_BITS);
}

// The rule whose action `choose` returns for the same arguments; -1 if no rule holds.
inline int chosen(const Mind& mind, const uint32_t* names, float alpha_grasp, const Stream<uint32_t>& lots) {
  if (const int reflex = mind.reflex ? mind.first_match(mind.reflex) : -1; reflex >= 0) return reflex;
  const Range range = quality_range(mind);
  uint32_t winner = 0;
  int rule = -1;
  for_each(mind.match, mind.words, [&](int r) {
    const Words drawn = tickets(mind, r / LANES * LANES, names, lots, range, alpha_grasp * (range.best - range.worst));
    const uint32_t ticket = drawn[r % LANES];
    if (ticket > winner || rule < 0) winner = ticket, rule = r;
  });
  return rule;
}

// An agent's decision in every episode: learn from the last step, then choose, unless a reflex holds (subsumption,
// R. Brooks 1986). A thing is done in all episodes before the next one is: they do not wait for each other's results.
// `step` counts from the call's beginning and names the place of action sets. minds: [LANES].
inline Ints decide(Mind* minds, const bool* awake, int step, const uint32_t* names, Floats reward, Floats alpha,
                   const Parameters& p, const Stream<Words>& lots) {
  float ahead[LANES];
  Range range[LANES];
  Ints action = all(NO_ACTION);
  const auto each = [&](auto work) {
    for (int lane = 0; lane < LANES; lane++)
      if (awake[lane]) work(lane, minds[lane]);
  };
  each([&](int lane, Mind& mind) { ahead[lane] = best_ahead(mind); });
  each([&](int lane, Mind& mind) {
    learn(mind, mind.set(step + HISTORY - 1), reward[lane], ahead[lane], alpha[lane], p.beta_q[lane]);
  });
  each([&](int lane, Mind& mind) { range[lane] = quality_range(mind); });
  each([&](int lane, Mind& mind) {
    const int reflex = mind.reflex ? mind.first_match(mind.reflex) : -1;
    action[lane] = reflex >= 0 ? (int)mind.action[reflex]
                               : choose(mind, range[lane], names, p.alpha_grasp[lane], in_lane(lots, lane));
  });
  each([&](int lane, Mind& mind) {
    const Bits* with_action = mind.rules_with(action[lane]);
    Bits* members = mind.set(step);
    for (int w = 0; w < mind.words; w++) members[w] = action[lane] == NO_ACTION ? 0 : mind.match[w] & with_action[w];
  });
  return action;
}

}  // namespace slcs2
