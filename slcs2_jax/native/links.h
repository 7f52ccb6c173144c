// The links of a time-step: received powers between all nodes, the jammers' answer, who hears whom. See swarm/links.py.
#pragma once
#include "fading.h"
#include "failure.h"
#include "geometry.h"
#include "jamming.h"
#include "radio.h"
#include "randomness.h"
#include "state.h"

namespace slcs2 {

// How far the names of two jammers' links are apart, and those of two words of a link.
constexpr uint32_t JAMMER_LINKS = 128, LINK_WORDS = 1 << 16;

// The uniform words of the links of a time-step.
class LinkWords {
 public:
  explicit LinkWords(const Group& g)
      : first_(stream(g.key_low, g.key_high, g.t, SHADOWING)), further_(stream(g.key_low, g.key_high, g.t, FADING)) {}

  Words draw(uint32_t link, int k) const {
    return k == 0 ? first_.draw(link) : further_.draw(link + (uint32_t)k * LINK_WORDS);
  }

 private:
  const Stream<Words> first_, further_;
};

// The mean power received over the link of node i and body j > i, mW: its logarithm to base 2.
inline Floats mean_level(const Group& g, int i, int j, const Crossings* crossings) {
  const Floats square = squared_distance(g.x[i], g.y[i], g.x[j], g.y[j]);
  return level(square, crossings ? crossings->counted(i, j) : all(0.0f), g.parameters);
}

// The links between so many nodes, the first jammer perhaps the last of them.
template <class Model>
inline void draw_table(Group& g, const Crossings* crossings, int places, const Model& fading) {
  const LinkWords words(g);
  for (int i = 0; i < places; i++) {
    Floats* power = g.power_of(i);
    power[i] = all(0.0f);
    for (int j = i + 1; j < places; j++) {
      const uint32_t name = (uint32_t)(i * g.places + j);
      const Floats gain = fading.gain([&](int k) { return words.draw(name, k); });
      power[j] = g.power_of(j)[i] = power_of_two(mean_level(g, i, j, crossings) + gain);
    }
  }
}

// The links of further jammers, each named by its number, so that no draw depends on how many there are room for.
template <class Model>
inline void draw_jammers(Group& g, const Crossings* crossings, int jammers, const Model& fading) {
  const Stream<Words> words = stream(g.key_low, g.key_high, g.t, JAMMER_LINK);
  for (int jammer = 1; jammer < jammers; jammer++)
    for (int i = 0; i < g.nodes; i++) {
      const uint32_t name = (uint32_t)jammer * JAMMER_LINKS + (uint32_t)i;
      const Floats gain = fading.gain([&](int k) { return words.draw(name + (uint32_t)k * LINK_WORDS); });
      g.power_of(g.nodes + jammer)[i] = power_of_two(mean_level(g, i, g.nodes + jammer, crossings) + gain);
    }
}

// The links of time-step t. Those of jammers are left out where there are none, as long as nobody reads them.
inline void draw(Group& g, const Crossings* crossings, bool all_jammers) {
  with_fading(g, [&](const auto& fading) {
    draw_table(g, crossings, all_jammers || g.any_jammer ? g.places : g.nodes, fading);
    draw_jammers(g, crossings, all_jammers ? g.sizes.jammers : g.jammers_present, fading);
  });
}

// Let the paper's jammer answer on the first channel in use; with another in use beacons get through on that one.
inline void let_the_jammer_answer(Group& g) {
  Mask earlier = mask(false), several = mask(false), first[MOST_CHANNELS];
  for (int c = 0; c < g.channels; c++) {
    first[c] = g.channel_used[c] & ~earlier;
    several |= g.channel_used[c] & earlier;
    earlier |= g.channel_used[c];
  }
  const Floats* from_jammer = g.power_of(g.nodes);
  Mask active = mask(false);
  if (g.any_jammer) {
    for (int j = 0; j < g.nodes; j++) active |= from_jammer[j] >= g.parameters.sensitivity;
    active &= g.has_jammer;
  }
  for (int j = 0; j < g.nodes; j++) {
    for (int c = 0; c < g.channels; c++)
      g.jamming[(size_t)c * g.nodes + j] = g.any_jammer ? where(active & first[c], from_jammer[j]) : all(0.0f);
    g.disturbance[j] = g.any_jammer ? where(active & ~several, from_jammer[j]) : all(0.0f);
  }
}

// Let the jammers answer, and see who hears whom: on one decoded channel or more.
inline void measure(Group& g) {
  const Parameters& p = g.parameters;
  if (g.sizes.failing) silence(g);
  if (g.sizes.jammers > 0)
    answer(g);
  else
    let_the_jammer_answer(g);
  for (int i = 0; i < g.n; i++) {
    const Floats needed = maximum(p.sensitivity, p.threshold * (p.noise + g.disturbance[i]));
    const Floats* power = g.power_of(i);
    Mask* heard = g.heard + (size_t)i * g.nodes;
    for (int j = 0; j < g.nodes; j++) heard[j] = power[j] >= needed;
  }
}

}  // namespace slcs2
