// The links of a time-step: received powers between all nodes, the jammer's answer, who hears whom. See swarm/links.py.
#pragma once
#include "geometry.h"
#include "randomness.h"
#include "state.h"

namespace slcs2 {

// log2 of the mean power received over each link, mW: P_t - PL(d) - walls * L_w (world/propagation.py, LogDistance).
inline Floats level(Floats square, Floats walls, const Parameters& p) {
  return p.gain - p.slope * logarithm2(maximum(square, all(p.floor))) - p.wall * walls;
}

// Received: power >= P_rs and signal to interference and noise >= threshold (world/radio.py, decodable).
inline Mask decodable(Floats signal, Floats disturbance, const Parameters& p) {
  return (signal >= p.sensitivity) & (signal >= p.threshold * (p.noise + disturbance));
}

// The links of time-step t. The jammer's are left out where there is none, as long as nobody reads them.
inline void draw(Group& g, const Crossings* crossings, bool with_jammer) {
  const Stream<Words> shadowing = stream(g.key_low, g.key_high, g.t, SHADOWING);
  const int places = with_jammer ? g.places : g.nodes;
  for (int i = 0; i < places; i++) {
    Floats* power = g.power_of(i);
    power[i] = all(0.0f);
    for (int j = i + 1; j < places; j++) {
      const Floats square = squared_distance(g.x[i], g.y[i], g.x[j], g.y[j]);
      const Floats walls = crossings ? crossings->counted(i, j) : all(0.0f);
      Floats received = level(square, walls, g.parameters);
      if (g.sizes.fading == LOG_NORMAL) {
        const Words word = shadowing.draw((uint32_t)(i * g.places + j));
        received += g.parameters.spread * normal(word);  // X ~ N(0, sigma^2) (world/fading.py, LogNormal)
      }
      power[j] = g.power_of(j)[i] = power_of_two(received);
    }
  }
}

// Let the jammer answer on the first channel in use, and see who hears whom: on one decoded channel or more.
inline void measure(Group& g) {
  const Parameters& p = g.parameters;
  Mask earlier = mask(false), several = mask(false), first[MOST_CHANNELS];
  for (int c = 0; c < g.channels; c++) {
    first[c] = g.channel_used[c] & ~earlier;
    several |= g.channel_used[c] & earlier;
    earlier |= g.channel_used[c];
  }
  const Floats* from_jammer = g.power_of(g.nodes);
  Mask active = mask(false);
  if (g.any_jammer) {
    for (int j = 0; j < g.nodes; j++) active |= from_jammer[j] >= p.sensitivity;
    active &= g.has_jammer;
  }
  for (int c = 0; c < g.channels; c++)
    for (int j = 0; j < g.nodes; j++)
      g.jamming[(size_t)c * g.nodes + j] = g.any_jammer ? where(active & first[c], from_jammer[j]) : all(0.0f);
  for (int i = 0; i < g.n; i++) {
    const Floats noise = g.any_jammer ? where(active & ~several, from_jammer[i]) : all(0.0f);
    const Floats needed = maximum(all(p.sensitivity), p.threshold * (p.noise + noise));
    const Floats* power = g.power_of(i);
    Mask* heard = g.heard + (size_t)i * g.nodes;
    for (int j = 0; j < g.nodes; j++) heard[j] = power[j] >= needed;
  }
}

}  // namespace slcs2
