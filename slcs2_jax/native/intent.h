// What an action means for the agent that takes it. See swarm/intent.py.
#pragma once
#include "geometry.h"
#include "roles.h"
#include "state.h"

namespace slcs2 {

// Numbers of the vocabulary (grammar/vocabulary.py).
constexpr int NO_ACTION = 255, MOVE_TARGETS = 7, SEND_TARGETS = 5, POWERS = 2, FIRST_COLLECT = 3 * MOVE_TARGETS;
constexpr int TOWARD = 0, ORBIT = 2;  // the other direction is away

// Numbers of those that depend on how many channels there are.
struct Actions {
  int settings, first_send, count;

  explicit Actions(const Sizes& s)
      : settings(s.vocabulary * POWERS), first_send(FIRST_COLLECT + settings),
        count(first_send + SEND_TARGETS * settings) {}
};

// Quotient of small numbers (0..255) by multiplication: vector units cannot divide integers.
inline Ints quotient(Ints number, int by) { return (number * (4096 / by + 1)) >> 12; }

// Resolve agent i's action against what it knows and hears; obstacles are looked for afterwards, for all agents at once.
inline void interpret(Group& g, int i, Ints action, const Candidates& everybody) {
  const Actions actions(g.sizes);
  Intent& intent = g.intent[i];
  intent.acts = action < actions.count;
  intent.moves = action < FIRST_COLLECT;
  intent.collects = (action >= FIRST_COLLECT) & (action < actions.first_send);
  intent.sends = (action >= actions.first_send) & intent.acts;
  intent.direction = quotient(action, MOVE_TARGETS);
  const Ints send_target = quotient(action - actions.first_send, actions.settings);
  const Ints target = intent.moves ? action - intent.direction * MOVE_TARGETS : send_target;
  const Ints setting =
      intent.sends ? action - actions.first_send - send_target * actions.settings : action - FIRST_COLLECT;
  intent.channel = quotient(setting, POWERS);
  const Mask full = setting - intent.channel * POWERS == 1;
  intent.level = full ? all(1.0f) : g.parameters.half_power;

  resolve(g, everybody, g.heard + (size_t)i * g.nodes, target, intent);
  const Mask to_jammer = intent.moves & (target == JAMMER);
  intent.place_known = to_jammer ? g.jammer_range[i] > 0 : intent.node < g.nodes;
  const bool several = g.sizes.jammers > 0;
  intent.place_x = to_jammer ? several ? g.believed_x[i] : g.jammer_x : intent.place_x;
  intent.place_y = to_jammer ? several ? g.believed_y[i] : g.jammer_y : intent.place_y;
  intent.to_obstacle = intent.moves & (target == OBSTACLE);
}

// For who moves with respect to an obstacle: the nearest point of a wall's surface or of another agent, walls first on
// ties, if it is within the lidar's range.
inline void find_obstacles(Group& g, const Walls* walls) {
  const Parameters& p = g.parameters;
  for (int i = 0; i < g.n; i++) {
    Intent& intent = g.intent[i];
    if (!any(intent.to_obstacle)) continue;
    Nearest best;
    if (walls) best = nearest_wall(*walls, intent.to_obstacle, g.x[i], g.y[i], p.lidar_range + 2 * SLACK, p);
    for (int j = 0; j < g.n; j++) {
      if (j == i) continue;
      best.take_nearer(squared_distance(g.x[i], g.y[i], g.x[j], g.y[j]), g.x[j], g.y[j]);
    }
    const Floats range = (p.lidar_range + SLACK) * (p.lidar_range + SLACK);
    intent.place_x = intent.to_obstacle ? best.x : intent.place_x;
    intent.place_y = intent.to_obstacle ? best.y : intent.place_y;
    intent.place_known = intent.to_obstacle ? best.squared <= range : intent.place_known;
  }
}

}  // namespace slcs2
