// Jammers where they are more than the paper's one: what they do, what agents know of them. See swarm/jamming.py.
#pragma once
#include <utility>

#include "emission.h"
#include "jammer_motion.h"
#include "state.h"

namespace slcs2 {

// What every jammer transmits, and what of it arrives: together on every channel, and on the best of those in use. One
// jammer after another is added, so that jammers that do not exist change no bit.
inline void answer(Group& g) {
  for (int jammer = 0; jammer < g.jammers_present; jammer++) {
    const Floats* power = g.power_of(g.nodes + jammer);
    Mask hears = mask(false);
    for (int j = 0; j < g.nodes; j++) hears |= power[j] >= g.parameters.sensitivity;
    g.emits[jammer] = transmits_on(g, jammer, hears);
    const Mask talks = g.emits[jammer] != SILENT;
    Floats* noise = g.noise + (size_t)jammer * g.nodes;
    for (int j = 0; j < g.nodes; j++) noise[j] = where(talks, power[j] * g.emitters[jammer].level);
  }
  for (int j = 0; j < g.nodes; j++) {
    Floats best = all(INFINITE);
    for (int c = 0; c < g.channels; c++) {
      Floats power = all(0.0f);
      for (int jammer = 0; jammer < g.jammers_present; jammer++)
        power += where(g.emits[jammer] == c, g.noise[(size_t)jammer * g.nodes + j]);
      g.jamming[(size_t)c * g.nodes + j] = power;
      best = g.channel_used[c] ? minimum(best, power) : best;
    }
    g.disturbance[j] = best;
  }
}

// Let every jammer make its step, from what it hears in this one.
inline void move_jammers(Group& g) {
  for (int jammer = 0; jammer < g.jammers_present; jammer++) {
    const Emitter& emitter = g.emitters[jammer];
    const Mask patrols = g.running & (emitter.motion == PATROL), pursues = g.running & (emitter.motion == PURSUE);
    Floats &x = g.x[g.nodes + jammer], &y = g.y[g.nodes + jammer];
    Place to{x, y};
    if (any(pursues)) {
      const Place there = pursue(g, jammer, g.power_of(g.nodes + jammer));
      to.x = pursues ? there.x : to.x, to.y = pursues ? there.y : to.y;
    }
    if (any(patrols)) {
      const Place there = patrol(emitter, g.sizes.points, g.t);
      to.x = patrols ? there.x : to.x, to.y = patrols ? there.y : to.y;
    }
    x = to.x, y = to.y;
  }
}

// Take as agent i's estimate the jammer whose last known place is nearest to it, the first of equals.
inline void take_nearest_jammer(Group& g, int i) {
  Floats best = all(INFINITE);
  g.jammer_range[i] = g.believed_x[i] = g.believed_y[i] = all(0.0f);
  for (int jammer = 0; jammer < g.jammers_present; jammer++) {
    const size_t news = (size_t)jammer * g.n + i;
    const Floats squared = squared_distance(g.x[i], g.y[i], g.seen_x[news], g.seen_y[news]);
    const Mask nearer = (g.seen_time[news] > UNKNOWN) & (squared < best);
    best = nearer ? squared : best;
    g.jammer_range[i] = nearer ? g.seen_range[news] : g.jammer_range[i];
    g.believed_x[i] = nearer ? g.seen_x[news] : g.believed_x[i];
    g.believed_y[i] = nearer ? g.seen_y[news] : g.believed_y[i];
  }
}

// Agent i enters every jammer whose noise reaches P_rs, with its place, the time and the greatest distance so far (xi).
inline void notice(Group& g, int i) {
  for (int jammer = 0; jammer < g.jammers_present; jammer++) {
    const size_t news = (size_t)jammer * g.n + i;
    const Mask heard = g.noise[(size_t)jammer * g.nodes + i] >= g.parameters.sensitivity;
    if (!any(heard)) continue;
    const Floats x = g.x[g.nodes + jammer], y = g.y[g.nodes + jammer];
    const Floats distance = root(squared_distance(g.x[i], g.y[i], x, y));
    g.seen_time[news] = heard ? g.t : g.seen_time[news];
    g.seen_x[news] = heard ? x : g.seen_x[news], g.seen_y[news] = heard ? y : g.seen_y[news];
    g.seen_range[news] = heard ? maximum(g.seen_range[news], distance) : g.seen_range[news];
  }
  take_nearest_jammer(g, i);
}

// Merge what those know who were heard: of a place the newest, of a range the greatest.
inline void share_jammers(Group& g) {
  for (int jammer = 0; jammer < g.sizes.jammers; jammer++)
    for (int i = 0; i < g.n; i++) {
      const size_t news = (size_t)jammer * g.n + i;
      const Mask* heard = g.heard + (size_t)i * g.nodes;
      Ints time = g.seen_time[news];
      Floats x = g.seen_x[news], y = g.seen_y[news], range = g.seen_range[news];
      for (int j = 0; j < g.n; j++) {
        const size_t theirs = (size_t)jammer * g.n + j;
        const Mask newer = heard[j] & (g.seen_time[theirs] > time);
        time = newer ? g.seen_time[theirs] : time;
        x = newer ? g.seen_x[theirs] : x, y = newer ? g.seen_y[theirs] : y;
        range = maximum(range, where(heard[j], g.seen_range[theirs]));
      }
      g.told_seen_time[news] = time, g.told_seen_x[news] = x, g.told_seen_y[news] = y;
      g.told_seen_range[news] = range;
    }
  std::swap(g.seen_time, g.told_seen_time), std::swap(g.seen_range, g.told_seen_range);
  std::swap(g.seen_x, g.told_seen_x), std::swap(g.seen_y, g.told_seen_y);
  for (int i = 0; i < g.n; i++) take_nearest_jammer(g, i);
}

}  // namespace slcs2
