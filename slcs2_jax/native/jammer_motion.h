// How a jammer moves: it flies, nothing stops it. See world/jammer_motion.py.
#pragma once
#include "elementary.h"
#include "state.h"

namespace slcs2 {

constexpr int PATROL = 1, PURSUE = 2;  // places in `arrays.MOTIONS`; the other one is fixed

struct Place {
  Floats x, y;  // m
};

// Round and round from point to point and back to the first: after t steps it is t * speed along the closed way.
inline Place patrol(const Emitter& emitter, int points, Ints t) {
  const Floats *x = emitter.route_x, *y = emitter.route_y;
  Floats step_x[MOST_POINTS], step_y[MOST_POINTS], length[MOST_POINTS], way = all(0.0f), start = all(0.0f);
  for (int leg = 0; leg < points; leg++) {
    const int next = leg + 1 < points ? leg + 1 : 0;
    step_x[leg] = x[next] - x[leg], step_y[leg] = y[next] - y[leg];
    length[leg] = root(step_x[leg] * step_x[leg] + step_y[leg] * step_y[leg]);
    way += length[leg];
  }
  way = maximum(way, all(1e-6f));
  Floats gone = emitter.speed * __builtin_convertvector(t + 1, Floats);
  gone = gone - whole_part(gone / way) * way;
  Place at{x[0], y[0]};
  for (int leg = 0; leg < points; leg++) {
    const Floats share = (gone - start) / maximum(length[leg], all(1e-6f));
    const Mask here = (share >= 0) & (share < 1) & (length[leg] > 0);
    at.x = here ? x[leg] + share * step_x[leg] : at.x, at.y = here ? y[leg] + share * step_y[leg] : at.y;
    start += length[leg];
  }
  return at;
}

// Straight toward whoever is received strongest, agent or node; it stays while it hears nobody. power: [nodes].
inline Place pursue(const Group& g, int jammer, const Floats* power) {
  const Place at{g.x[g.nodes + jammer], g.y[g.nodes + jammer]};
  Floats loudest = power[0];
  Place of{g.x[0], g.y[0]};
  for (int j = 1; j < g.nodes; j++) {
    const Mask louder = power[j] > loudest;
    loudest = louder ? power[j] : loudest;
    of.x = louder ? g.x[j] : of.x, of.y = louder ? g.y[j] : of.y;
  }
  const Floats dx = of.x - at.x, dy = of.y - at.y, distance = root(dx * dx + dy * dy);
  const Mask moves = (loudest >= g.parameters.sensitivity) & (distance > 0);
  const Floats share = where(moves, minimum(g.emitters[jammer].speed, distance) / (moves ? distance : all(1.0f)));
  return {at.x + share * dx, at.y + share * dy};
}

}  // namespace slcs2
