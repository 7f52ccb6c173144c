// The reward of a step (paper, reward equation). See swarm/reward.py.
#pragma once
#include "elementary.h"
#include "packets.h"
#include "state.h"

namespace slcs2 {

// rho = ln(|rho_p| + 1) sgn(rho_p) + rho_s - C_a.
inline void reward_agents(Group& g, const Traffic& traffic) {
  const Parameters& p = g.parameters;
  for (int i = 0; i < g.n; i++) {
    const Floats to_sink = root(squared_distance(g.x[i], g.y[i], g.estimate_x, g.estimate_y));
    const Floats to_source = root(squared(g.x[i]) + squared(g.y[i]));
    const Mask kept = traffic.held[i] & ~traffic.sent[i];
    const Floats packets = where(kept, g.to_sink[i] - to_sink) + traffic.progress[i];
    const Floats seeking = where(~(traffic.held[i] | traffic.received[i]), g.to_source[i] - to_source);
    const Floats cost = g.intent[i].moves ? p.cost_move : p.cost_communicate;
    g.reward[i] = with_sign_of(logarithm(magnitude(packets) + 1.0f), packets) + seeking - cost;
  }
}

}  // namespace slcs2
