// Roles: source-side, sink-side and closest among those known or heard. See swarm/roles.py.
#pragma once
#include "state.h"

namespace slcs2 {

constexpr int SO = 0, SI = 1, C = 2, SOURCE = 3, SINK = 4, JAMMER = 5, OBSTACLE = 6;  // grammar/vocabulary.py, MOVE_TARGETS

// Whom one agent may mean, [nodes]: other agents at their last known places, the source, the sink where it believes it.
struct Candidates {
  Floats x[MOST_NODES], y[MOST_NODES], squared[MOST_NODES];
  Mask known[MOST_NODES], source_side[MOST_NODES], sink_side[MOST_NODES];
};

// The squared distance, m2, below which something is nearer beyond rounding.
inline Floats nearer(Floats square) { return squared(maximum(root(square) - SLACK, all(0.0f))); }

// Place everybody as agent i knows them.
inline void find_candidates(const Group& g, int i, Candidates& c) {
  const Floats zero = all(0.0f);
  const Floats to_source = nearer(squared_distance(zero, zero, g.x[i], g.y[i]));
  const Floats to_sink = nearer(squared_distance(g.x[i], g.y[i], g.estimate_x, g.estimate_y));
  for (int j = 0; j < g.nodes; j++) {
    const size_t pair = (size_t)i * g.n + j;
    const Floats x = j < g.n ? g.known_x[pair] : j == g.n ? zero : g.estimate_x;
    const Floats y = j < g.n ? g.known_y[pair] : j == g.n ? zero : g.estimate_y;
    c.x[j] = x, c.y[j] = y;
    c.known[j] = j < g.n ? g.known_time[pair] > UNKNOWN : mask(true);
    c.squared[j] = squared_distance(g.x[i], g.y[i], x, y);
    c.source_side[j] = squared(x) + squared(y) < to_source;
    c.sink_side[j] = squared_distance(x, y, g.estimate_x, g.estimate_y) < to_sink;
  }
}

struct Closest {
  Floats source_side, sink_side, any;  // m; infinite if there is none
};

inline Closest closest(const Candidates& c, int nodes) {
  Floats source_side = all(INFINITE), sink_side = source_side, any = source_side;
  for (int j = 0; j < nodes; j++) {
    const Floats squared = c.known[j] ? c.squared[j] : all(INFINITE);
    any = minimum(any, squared);
    source_side = minimum(source_side, c.source_side[j] ? squared : all(INFINITE));
    sink_side = minimum(sink_side, c.sink_side[j] ? squared : all(INFINITE));
  }
  return {root(source_side), root(sink_side), root(any)};
}

// The node that a target other than jammer or obstacle stands for: the closest with the role, the lowest index of those
// as close within SLACK; `nodes` if there is none. Members: K for movement, N for sending.
inline void resolve(const Group& g, const Candidates& c, const Mask* heard, Ints target, Intent& intent) {
  const Mask to_so = target == SO, to_si = target == SI, to_any = target == C, to_source = target == SOURCE;
  const Mask to_sink = target > SOURCE;
  Floats squared[MOST_NODES], best = all(INFINITE);
  for (int j = 0; j < g.nodes; j++) {
    const Mask member = intent.sends ? heard[j] : c.known[j];
    Mask role = to_any | (to_so & c.source_side[j]) | (to_si & c.sink_side[j]);
    if (j == g.n) role |= to_source;
    if (j == g.n + 1) role |= to_sink;
    squared[j] = member & role ? c.squared[j] : all(INFINITE);
    best = minimum(best, squared[j]);
  }
  const Floats tie = slcs2::squared(root(best) + SLACK);
  intent.node = all(g.nodes);
  intent.place_x = intent.place_y = all(0.0f);
  for (int j = g.nodes - 1; j >= 0; j--) {
    const Mask equal = (squared[j] <= tie) & (squared[j] < INFINITE);
    intent.node = equal ? all(j) : intent.node;
    intent.place_x = equal ? c.x[j] : intent.place_x;
    intent.place_y = equal ? c.y[j] : intent.place_y;
  }
}

}  // namespace slcs2
