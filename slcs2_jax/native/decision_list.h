// A behaviour made by hand: the first rule that holds acts (paper, human-designed comparisons). See
// policy/decision_list.py.
#pragma once
#include "mind.h"

namespace slcs2 {

// The first rule that holds, which is used; -1 if there is none.
inline int first_match(const Mind& mind) {
  for (int w = 0; w < mind.words; w++)
    if (mind.match[w]) return w * 64 + __builtin_ctzll(mind.match[w]);
  return -1;
}

inline int decide_by_list(Mind& mind) {
  const int first = first_match(mind);
  if (first < 0) return NO_ACTION;
  mind.usage[first]++;
  return mind.action[first];
}

}  // namespace slcs2
