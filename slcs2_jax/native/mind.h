// One agent's rules and what it has learnt, in one episode. Rules are scalar here: an agent looks at those few that hold.
#pragma once
#include "observation.h"
#include "state.h"

namespace slcs2 {

// One bit for every rule.
typedef uint64_t Bits;

// Clauses, 128 of them.
struct Clauses {
  Bits word[2];
};

inline Clauses in_lane(const Truth& truth, int lane) {
  return {{truth.word[0][lane] | (Bits)truth.word[1][lane] << 32, truth.word[2][lane] | (Bits)truth.word[3][lane] << 32}};
}

struct Rule {
  float quality, error, strength;  // q, epsilon, zeta (paper, table of a rule's parameters)
  int32_t usage;                   // tau
};

struct Mind {
  const Sizes* sizes;
  int words;          // of bits for all rules
  Rule* rule;         // [R]
  Clauses* condition; // [R]
  uint8_t* action;    // [R]
  Bits* stating;      // [128 clauses, words], the rules whose condition states the clause
  Bits* match;        // [words], the match set Gamma' of this step
  Bits* sets;         // [HISTORY, words], the action sets of the last steps, a ring
  Clauses truth;      // of the step that `match` is of

  static Mind take(Store& store, const Sizes& s) {
    const int words = s.rule_words();
    return {&s, words, store.take<Rule>(s.rules), store.take<Clauses>(s.rules), store.take<uint8_t>(s.rules),
            store.take<Bits>(128 * (size_t)words), store.take<Bits>(words), store.take<Bits>(HISTORY * (size_t)words),
            Clauses{}};
  }

  bool holds(int r) const {
    return !((condition[r].word[0] & ~truth.word[0]) | (condition[r].word[1] & ~truth.word[1]));
  }

  // The rules are in place: see which clauses they state, and which hold while nothing is true.
  void begin() {
    memset(stating, 0, 128 * (size_t)words * sizeof(Bits));
    memset(match, 0, words * sizeof(Bits));
    truth = {};
    for (int r = 0; r < sizes->rules; r++) {
      for (int half = 0; half < 2; half++)
        for (Bits left = condition[r].word[half]; left; left &= left - 1)
          stating[(half * 64 + __builtin_ctzll(left)) * (size_t)words + r / 64] |= Bits(1) << (r % 64);
      if (holds(r)) match[r / 64] |= Bits(1) << (r % 64);
    }
  }

  // The match set: the rules whose every clause holds. Only those that state a clause whose truth has changed are looked
  // at, so rules that can never hold cost nothing.
  void see(const Clauses& now) {
    Clauses lost, won;
    for (int half = 0; half < 2; half++) {
      lost.word[half] = truth.word[half] & ~now.word[half];
      won.word[half] = now.word[half] & ~truth.word[half];
    }
    truth = now;
    for (int half = 0; half < 2; half++)
      for (Bits left = lost.word[half]; left; left &= left - 1) {
        const Bits* rules = stating + (half * 64 + __builtin_ctzll(left)) * (size_t)words;
        for (int w = 0; w < words; w++) match[w] &= ~rules[w];
      }
    for (int half = 0; half < 2; half++)
      for (Bits left = won.word[half]; left; left &= left - 1) {
        const Bits* rules = stating + (half * 64 + __builtin_ctzll(left)) * (size_t)words;
        for (int w = 0; w < words; w++)
          for (Bits maybe = rules[w] & ~match[w]; maybe; maybe &= maybe - 1) {
            const int r = w * 64 + __builtin_ctzll(maybe);
            if (holds(r)) match[w] |= maybe & -maybe;
          }
      }
  }

  Bits* set(int step) const { return sets + (size_t)(step % HISTORY) * words; }
};

// Call `visit(rule's number)` for every bit, in ascending order.
template <class Visit>
inline void for_each(const Bits* bits, int words, Visit visit) {
  for (int w = 0; w < words; w++)
    for (Bits left = bits[w]; left; left &= left - 1) visit(w * 64 + __builtin_ctzll(left));
}

}  // namespace slcs2
