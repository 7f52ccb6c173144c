// What an agent observes: the truth of every clause that a rule may state. See swarm/observation.py.
#pragma once
#include "roles.h"
#include "state.h"

namespace slcs2 {

// Numbers of the vocabulary (grammar/vocabulary.py).
constexpr int LEFT = 5, RIGHT = 6, JAMMER_RANGE = 5, OPERATORS = 3;
constexpr int NOISE_ON_FIRST = 0, PACKET = 1, NO_PACKET = 2, NODE = 3, NO_NODE = 4;
constexpr int FIRST_DISTANCE = 5, FIRST_JAMMER_DISTANCE = 80, FIRST_NOISE = 95;

inline constexpr int distance_clause(int left, int comparison, int right) {
  return right == JAMMER_RANGE ? FIRST_JAMMER_DISTANCE + left * 3 + comparison
                               : FIRST_DISTANCE + (left * 3 + comparison) * 5 + right;
}

struct Truth {
  Words word[CLAUSE_WORDS];

  void put(int clause, Mask holds) { word[clause / 32] |= (Words)holds & (1u << (clause % 32)); }
};

// Agent i's observation. Nothing is true for the agents of an episode that is over,
// nor for one that is down. `needed`: the clauses that any rule
// states; the others are left false.
inline Truth observe(Group& g, int i, const Candidates& everybody, const uint32_t* needed) {
  const Parameters& p = g.parameters;
  const Mask* heard = g.heard + (size_t)i * g.nodes;
  const Closest role = closest(everybody, g.nodes);
  g.to_sink[i] = root(squared_distance(g.x[i], g.y[i], g.estimate_x, g.estimate_y));
  g.to_source[i] = root(squared(g.x[i]) + squared(g.y[i]));
  const Floats left[LEFT] = {role.source_side, role.sink_side, role.any, g.to_sink[i], g.to_source[i]};
  const Floats range = g.jammer_range[i] > 0 ? g.jammer_range[i] : all(INFINITE);
  const Floats right[RIGHT] = {left[0], left[1], left[2], p.distance_threshold, p.network_range, range};
  const Mask node = heard[g.n] | heard[g.n + 1];

  Truth truth{};
  truth.put(PACKET, g.holding[i]);
  truth.put(NO_PACKET, ~g.holding[i]);
  truth.put(NODE, node);
  truth.put(NO_NODE, ~node);
  for (int c = 0; c < g.channels; c++) {
    const Mask quiet = g.interference[(size_t)i * g.channels + c] <= p.sensitivity;
    truth.put(c == 0 ? NOISE_ON_FIRST : FIRST_NOISE + c - 1, quiet);
  }
  Floats defined[LEFT];  // an undefined operand is no number: every comparison with it is false
  for (int l = 0; l < LEFT; l++) defined[l] = left[l] < INFINITE ? left[l] : all(__builtin_nanf(""));
  for (int r = 0; r < RIGHT; r++) {
    if (r == JAMMER_RANGE && !(needed[2] >> 16 & 0x7FFF)) continue;  // its fifteen clauses
    const Floats b = right[r] < INFINITE ? right[r] : all(__builtin_nanf(""));
    const Floats tolerance = maximum(p.speed, p.tolerance * b) + SLACK;
    const Floats less = b - SLACK, more = b + SLACK, low = b - tolerance, high = b + tolerance;
    for (int l = 0; l < LEFT; l++) {
      truth.put(distance_clause(l, 0, r), defined[l] < less);
      truth.put(distance_clause(l, 1, r), defined[l] > more);
      truth.put(distance_clause(l, 2, r), (defined[l] <= high) & (defined[l] >= low));
    }
  }
  const Mask able = g.sizes.failing ? g.running & ~g.down[i] : g.running;
  for (Words& word : truth.word) word &= (Words)able;
  return truth;
}

}  // namespace slcs2
