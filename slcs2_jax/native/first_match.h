// A behaviour made by hand: the first rule that holds acts (paper, human-designed comparisons). See
// policy/first_match.py.
#pragma once
#include "mind.h"

namespace slcs2 {

inline int decide_by_list(Mind& mind) {
  const int first = mind.first_match();
  if (first < 0) return NO_ACTION;
  mind.usage[first]++;
  return (int)mind.action[first];
}

}  // namespace slcs2
