// Knowledge K: last known positions, own and shared. See swarm/knowledge.py.
#pragma once
#include <utility>

#include "jamming.h"
#include "state.h"

namespace slcs2 {

// Agent i enters who is heard now, with place and time, and the jammer where its noise reaches P_rs.
inline void enter_neighbours(Group& g, int i) {
  const Mask* heard = g.heard + (size_t)i * g.nodes;
  Ints* time = g.known_time + (size_t)i * g.n;
  Floats *x = g.known_x + (size_t)i * g.n, *y = g.known_y + (size_t)i * g.n;
  for (int j = 0; j < g.n; j++) {
    time[j] = heard[j] ? g.t : time[j];
    x[j] = heard[j] ? g.x[j] : x[j];
    y[j] = heard[j] ? g.y[j] : y[j];
  }
  if (!g.any_jammer) return;
  if (g.sizes.jammers > 0) {
    notice(g, i);
    return;
  }
  Floats noise = all(0.0f);
  for (int c = 0; c < g.channels; c++) noise = maximum(noise, g.jamming[(size_t)c * g.nodes + i]);
  const Floats distance = root(squared_distance(g.x[i], g.y[i], g.jammer_x, g.jammer_y));
  const Mask noticed = noise >= g.parameters.sensitivity;
  g.jammer_range[i] = noticed ? maximum(g.jammer_range[i], distance) : g.jammer_range[i];
}

// Every agent merges what those whom it heard in the last step know; the newest time wins.
inline void share(Group& g) {
  const size_t n = g.n;
  Floats range[MOST_AGENTS];
  for (size_t i = 0; i < n; i++) {
    const Mask* heard = g.heard + i * g.nodes;
    Ints* time = g.told_time + i * n;
    Floats *x = g.told_x + i * n, *y = g.told_y + i * n;
    memcpy(time, g.known_time + i * n, n * sizeof *time);
    memcpy(x, g.known_x + i * n, n * sizeof *x);
    memcpy(y, g.known_y + i * n, n * sizeof *y);
    range[i] = g.jammer_range[i];
    for (size_t j = 0; j < n; j++) {
      if (!any(heard[j])) continue;
      const Ints* theirs = g.known_time + j * n;
      for (size_t other = 0; other < n; other++) {
        const Mask newer = heard[j] & (theirs[other] > time[other]);
        time[other] = newer ? theirs[other] : time[other];
        x[other] = newer ? g.known_x[j * n + other] : x[other];
        y[other] = newer ? g.known_y[j * n + other] : y[other];
      }
      if (g.sizes.jammers == 0) range[i] = maximum(range[i], where(heard[j], g.jammer_range[j]));
    }
    time[i] = g.known_time[i * n + i], x[i] = g.known_x[i * n + i], y[i] = g.known_y[i * n + i];  // of others only
  }
  std::swap(g.known_time, g.told_time), std::swap(g.known_x, g.told_x), std::swap(g.known_y, g.told_y);
  for (size_t i = 0; i < n; i++) g.jammer_range[i] = range[i];
  if (g.sizes.jammers > 0) share_jammers(g);
}

}  // namespace slcs2
