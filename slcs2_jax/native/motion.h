// Motion: toward, away and orbit, and the clearance that nobody breaks. See swarm/motion.py.
#pragma once
#include "geometry.h"
#include "intent.h"
#include "state.h"

namespace slcs2 {

struct Motion {
  Floats step_x[MOST_AGENTS], step_y[MOST_AGENTS], to_x[MOST_AGENTS], to_y[MOST_AGENTS];
  Floats side_x[MOST_AGENTS], side_y[MOST_AGENTS], new_x[MOST_AGENTS], new_y[MOST_AGENTS];
  Mask steps[MOST_AGENTS], refused[MOST_AGENTS];
};

// The step that agent i would make if nothing were in its way. Toward stops at the clearance; away takes a whole step;
// orbit goes counter-clockwise along a chord of the circle around the target, so that the radius is kept.
inline void propose(const Group& g, int i, Motion& m) {
  const Parameters& p = g.parameters;
  const Intent& intent = g.intent[i];
  const Floats dx = intent.place_x - g.x[i], dy = intent.place_y - g.y[i];
  Floats distance = root(dx * dx + dy * dy);
  const Mask possible = intent.moves & intent.place_known & (distance > 0);
  distance = possible ? distance : all(1.0f);
  const Floats ux = dx / distance, uy = dy / distance;
  const Floats toward = minimum(maximum(distance - p.clearance, all(0.0f)), p.speed);
  const Floats along = intent.direction == TOWARD ? toward : -p.speed;
  // The chord s of a circle of radius d makes an angle with the tangent whose sine is s / 2d.
  const Floats chord = minimum(p.speed, 2.0f * distance), inward = chord / (2.0f * distance);
  const Floats ahead = root(1.0f - inward * inward);
  const Mask orbits = intent.direction == ORBIT;
  m.step_x[i] = where(possible, orbits ? chord * (inward * ux + ahead * uy) : along * ux);
  m.step_y[i] = where(possible, orbits ? chord * (inward * uy - ahead * ux) : along * uy);
  m.to_x[i] = g.x[i] + m.step_x[i], m.to_y[i] = g.y[i] + m.step_y[i];
  m.steps[i] = possible;
}

// Whether a move of agent i to (x, y) comes too near to where agent j is or would be.
inline Mask too_near(const Group& g, int i, int j, Floats x, Floats y, Floats other_x, Floats other_y) {
  const Floats before = squared_distance(g.x[i], g.y[i], g.x[j], g.y[j]);
  return squared_distance(x, y, other_x, other_y) < minimum(g.parameters.clear, before);
}

// Let the nearest agent that forbids the proposal replace `best` where it is nearer, seen from the present place.
inline void find_blocking_agent(const Group& g, int i, const Motion& m, const Floats* other_x, const Floats* other_y,
                                Nearest& best) {
  for (int j = 0; j < g.n; j++) {
    if (j == i) continue;
    const Mask blocks = too_near(g, i, j, m.to_x[i], m.to_y[i], other_x[j], other_y[j]);
    if (!any(blocks)) continue;
    const Floats square = squared_distance(g.x[i], g.y[i], other_x[j], other_y[j]);
    best.take_nearer(blocks ? square : all(INFINITE), other_x[j], other_y[j]);
  }
}

// The part of a step across the direction to the obstacle; no step if the agent touches it.
inline void slide(const Group& g, int i, const Nearest& obstacle, Motion& m) {
  const Mask possible = m.refused[i] & (obstacle.squared > 0);
  const Floats distance = root(possible ? obstacle.squared : all(1.0f));
  const Floats nx = (obstacle.x - g.x[i]) / distance, ny = (obstacle.y - g.y[i]) / distance;
  const Floats into = m.step_x[i] * nx + m.step_y[i] * ny;
  m.side_x[i] = g.x[i] + where(possible, m.step_x[i] - into * nx);
  m.side_y[i] = g.y[i] + where(possible, m.step_y[i] - into * ny);
}

// Whether agent i's tangent step is not allowed either.
inline Mask hindered(const Group& g, const Walls* walls, int i, const Motion& m) {
  const Floats x = m.side_x[i], y = m.side_y[i];
  Mask hinders = mask(false);
  if (walls) hinders = blocking_wall(*walls, m.refused[i], g.x[i], g.y[i], x, y, g.parameters).squared < INFINITE;
  for (int j = 0; j < g.n; j++) {
    if (j == i) continue;
    hinders |= too_near(g, i, j, x, y, g.x[j], g.y[j]) | too_near(g, i, j, x, y, m.to_x[j], m.to_y[j]) |
               (m.refused[j] & too_near(g, i, j, x, y, m.side_x[j], m.side_y[j]));
  }
  return hinders;
}

// Everybody's new place. A proposal that would bring an agent nearer than the clearance (or than it is) to a wall,
// another's place or another's proposal is replaced by its projection on the tangent of the nearest obstacle in its way,
// if that is allowed; else the agent stays. Who does not step stays where it is, whatever is near.
inline void move(Group& g, const Walls* walls, Motion& m) {
  bool none = true, none_refused = true;
  for (int i = 0; i < g.n; i++) {
    propose(g, i, m);
    none &= !any(m.steps[i]);
  }
  if (none) return;
  for (int i = 0; i < g.n; i++) {
    m.refused[i] = mask(false);
    m.side_x[i] = g.x[i], m.side_y[i] = g.y[i];
    if (!any(m.steps[i])) continue;
    Nearest obstacle;
    if (walls) obstacle = blocking_wall(*walls, m.steps[i], g.x[i], g.y[i], m.to_x[i], m.to_y[i], g.parameters);
    find_blocking_agent(g, i, m, g.x, g.y, obstacle);
    find_blocking_agent(g, i, m, m.to_x, m.to_y, obstacle);
    m.refused[i] = m.steps[i] & (obstacle.squared < INFINITE);
    if (!any(m.refused[i])) continue;
    none_refused = false;
    slide(g, i, obstacle, m);
  }
  for (int i = 0; i < g.n; i++) {
    m.new_x[i] = m.to_x[i], m.new_y[i] = m.to_y[i];
    if (none_refused || !any(m.refused[i])) continue;
    const Mask stays = hindered(g, walls, i, m);
    m.new_x[i] = m.refused[i] ? (stays ? g.x[i] : m.side_x[i]) : m.to_x[i];
    m.new_y[i] = m.refused[i] ? (stays ? g.y[i] : m.side_y[i]) : m.to_y[i];
  }
  for (int i = 0; i < g.n; i++) g.x[i] = m.new_x[i], g.y[i] = m.new_y[i];
}

}  // namespace slcs2
