// The rule-set classifier: match, learn, choose. See policy/classifier.py, qlearning.py and grasp.py.
#pragma once
#include "intent.h"
#include "mind.h"
#include "randomness.h"

namespace slcs2 {

struct Choice {
  int action, rule;  // NO_ACTION and -1 if no rule holds
};

// Q-learning over the last action set once the next match set is known (paper, quality and error equations):
// q <- (1 - alpha) q + alpha (rho + beta max q ahead); error <- (1 - alpha) error + alpha |rho - q|, q before the update.
inline void learn(Mind& mind, const Bits* members, float reward, float ahead, float alpha, float beta) {
  const float target = alpha * (reward + beta * ahead), rest = 1.0f - alpha;
  for_each(members, mind.words, [&](int r) {
    Rule& rule = mind.rule[r];
    rule.error = alpha * std::fabs(reward - rule.quality) + rest * rule.error;
    rule.quality = target + rest * rule.quality;
  });
}

// The greatest quality in the match set, 0 if it is empty.
inline float best_ahead(const Mind& mind) {
  float best = -INFINITE;
  for_each(mind.match, mind.words, [&](int r) { best = std::max(best, mind.rule[r].quality); });
  return best > -INFINITE ? best : 0.0f;
}

// A rule drawn uniformly from those of the match set with q >= q_max - alpha_grasp (q_max - q_min) (paper, GRASP
// equation): each draws a ticket whose low bits carry its action, and the greatest ticket wins.
inline Choice choose(const Mind& mind, int agent, float alpha_grasp, const Stream<uint32_t>& lots) {
  float best = -INFINITE, worst = INFINITE;
  for_each(mind.match, mind.words, [&](int r) {
    best = std::max(best, mind.rule[r].quality), worst = std::min(worst, mind.rule[r].quality);
  });
  if (!(best > -INFINITE)) return {NO_ACTION, -1};
  const float reach = alpha_grasp * (best - worst);
  uint32_t winner = 0;
  int rule = -1;
  for_each(mind.match, mind.words, [&](int r) {
    if (!(best - mind.rule[r].quality <= reach)) return;
    const uint32_t ticket = (lots.draw((uint32_t)(r * mind.sizes->agents + agent)) & ~0xFFu) | mind.action[r];
    if (rule < 0 || ticket > winner) winner = ticket, rule = r;
  });
  return {(int)(winner & 0xFF), rule};
}

// Learn from the last step, then choose. `step` counts from the call's beginning and names the place of action sets.
inline Choice decide(Mind& mind, int agent, int step, float reward, float alpha, const Parameters& p,
                     const Stream<uint32_t>& lots) {
  learn(mind, mind.set(step + HISTORY - 1), reward, best_ahead(mind), alpha, p.beta_q);
  const Choice choice = choose(mind, agent, p.alpha_grasp, lots);
  Bits* members = mind.set(step);
  for (int w = 0; w < mind.words; w++) {
    members[w] = 0;
    for (Bits left = mind.match[w]; left; left &= left - 1)
      if (mind.action[w * 64 + __builtin_ctzll(left)] == choice.action) members[w] |= left & -left;
  }
  return choice;
}

}  // namespace slcs2
