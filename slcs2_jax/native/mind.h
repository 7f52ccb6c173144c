// One agent's rules and what it has learnt, in one episode. Here the lanes of vectors are rules.
#pragma once
#include "intent.h"
#include "observation.h"
#include "state.h"

namespace slcs2 {

typedef uint64_t Bits;  // one for every rule

// Call `visit(number)` for every bit, in ascending order.
template <class Visit>
inline void for_each(const Bits* bits, int words, Visit visit) {
  for (int w = 0; w < words; w++)
    for (Bits left = bits[w]; left; left &= left - 1) visit(w * 64 + __builtin_ctzll(left));
}

// Arrays of floats and words have room for whole vectors; what is beyond the last rule never matches.
struct Mind {
  const Sizes* sizes;
  int words;                          // of bits for all rules
  int actions;                        // of the vocabulary
  float *quality, *error, *strength;  // [R], q, epsilon, zeta (paper, table of a rule's parameters)
  int32_t* usage;                     // [R], tau, without the last action set
  float* matched;                     // [R], quality of the rules in the match set, no number for the others
  uint32_t* condition;                // [words of a condition, R]
  uint32_t* action;                   // [R]
  Bits* acting;                       // [actions of the vocabulary and one for the rest, words], the rules with each
  Bits* match;                        // [words], the match set Gamma' of this step
  Bits* reflex;                       // [words], the rules that act whenever they hold; null where there are none
  Bits* sets;                         // [HISTORY, words], the action sets of the last steps, a ring
  uint32_t truth[CLAUSE_WORDS];       // of the step that `match` is of

  static size_t whole_vectors(const Sizes& s) { return ((size_t)s.rules + LANES - 1) / LANES * LANES; }

  static Mind take(Store& store, const Sizes& s) {
    const size_t words = s.rule_words(), rules = whole_vectors(s);
    Mind m{};
    m.sizes = &s, m.words = (int)words, m.actions = Actions(s).count;
    for (float** array : {&m.quality, &m.error, &m.strength, &m.matched}) *array = store.take<float>(rules);
    m.usage = store.take<int32_t>(rules), m.action = store.take<uint32_t>(rules);
    m.condition = store.take<uint32_t>(s.words * rules);
    m.acting = store.take<Bits>((m.actions + 1) * words);
    m.match = store.take<Bits>(words), m.sets = store.take<Bits>(HISTORY * words);
    m.reflex = s.reflexes ? store.take<Bits>(words) : nullptr;
    return m;
  }

  const Bits* rules_with(uint32_t action_) const { return acting + std::min<size_t>(action_, actions) * words; }

  Bits* set(int step) const { return sets + (size_t)(step % HISTORY) * words; }

  // The rules are in place: sort them by what they do, and see which hold while nothing is true.
  void begin() {
    const size_t rules = whole_vectors(*sizes);
    for (size_t r = sizes->rules; r < rules; r++) {
      quality[r] = 0.0f, action[r] = 0;
      for (int w = 0; w < sizes->words; w++) condition[w * rules + r] = 0;
    }
    memset(acting, 0, (actions + 1) * (size_t)words * sizeof(Bits));
    for (int r = 0; r < sizes->rules; r++)
      acting[std::min<size_t>(action[r], actions) * words + r / 64] |= Bits(1) << (r % 64);
    memset(truth, 0, sizeof truth);
    match_all();
  }

  // The first rule that holds, of all or of the reflexes; -1 if there is none.
  int first_match(const Bits* among = nullptr) const {
    for (int w = 0; w < words; w++)
      if (const Bits holding = match[w] & (among ? among[w] : ~Bits(0))) return w * 64 + __builtin_ctzll(holding);
    return -1;
  }

  // The match set of the clauses that are true now; found anew only if they are others than before.
  void see(const uint32_t* now) {
    if (memcmp(truth, now, sizeof truth) == 0) return;
    memcpy(truth, now, sizeof truth);
    match_all();
  }

 private:
  // The match set: the rules whose every clause holds.
  void match_all() {
    const size_t rules = whole_vectors(*sizes);
    memset(match, 0, words * sizeof(Bits));
    for (size_t r = 0; r < rules; r += LANES) {
      Words unmet = all(0u);
      for (int w = 0; w < sizes->words; w++) unmet |= load<Words>(condition + w * rules + r) & ~truth[w];
      const Mask holds = (Mask)(unmet == 0u) & (numbered() < (int32_t)(sizes->rules - r));
      const Floats qualities = holds ? load<Floats>(quality + r) : all(__builtin_nanf(""));
      memcpy(matched + r, &qualities, sizeof qualities);
      match[r / 64] |= (Bits)lanes_of(holds) << (r % 64);
    }
  }
};

}  // namespace slcs2
