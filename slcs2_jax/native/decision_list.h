// A behaviour made by hand: the first rule that holds acts (paper, human-designed comparisons). See
// policy/decision_list.py.
#pragma once
#include "classifier.h"
#include "mind.h"

namespace slcs2 {

inline Choice first_match(Mind& mind) {
  for (int w = 0; w < mind.words; w++) {
    if (!mind.match[w]) continue;
    const int r = w * 64 + __builtin_ctzll(mind.match[w]);
    mind.rule[r].usage++;
    return {mind.action[r], r};
  }
  return {NO_ACTION, -1};
}

}  // namespace slcs2
