// When, and on which channel, a jammer transmits. See world/emission.py.
#pragma once
#include "randomness.h"
#include "state.h"

namespace slcs2 {

constexpr int SILENT = -1;
constexpr int REACTIVE = 0, RANDOM = 2, SWEEPING = 3;  // places in `arrays.EMISSIONS`; the other one is constant

// The channel in use with a number among those in use, modulo how many there are.
inline Ints in_use(const Group& g, Ints number) {
  Ints count = all(0), before = all(0), found = all(SILENT);
  for (int c = 0; c < g.channels; c++) count -= g.channel_used[c];
  number = number % (count > 1 ? count : all(1));
  for (int c = 0; c < g.channels; c++) {
    const Mask here = g.channel_used[c] & (before == number);
    found = here ? all(c) : found;
    before -= g.channel_used[c];
  }
  return found;
}

// In intervals of `dwell` steps, each with chance `duty`, on a channel in use drawn for it.
inline Ints randomly(const Group& g, int jammer) {
  const Emitter& emitter = g.emitters[jammer];
  const Words word = stream(g.key_low, g.key_high, g.t / emitter.dwell, EMISSION).draw((uint32_t)jammer);
  const Ints channel = in_use(g, (Ints)(mix(word) >> 8));
  return uniform(word) < emitter.duty ? channel : all(SILENT);
}

// Always, on one channel in use after another, each for `dwell` steps; the next jammer is always one channel ahead.
inline Ints sweeping(const Group& g, int jammer) { return in_use(g, g.t / g.emitters[jammer].dwell + jammer); }

// The channel that a jammer transmits on. A reactive one, the paper's, does so on the first on which it receives
// anything; a constant one always, on the first in use.
inline Ints transmits_on(const Group& g, int jammer, Mask hears) {
  const Emitter& emitter = g.emitters[jammer];
  const Mask draws = emitter.emission == RANDOM, sweeps = emitter.emission == SWEEPING;
  const Mask talks = emitter.emission == REACTIVE ? hears : mask(true);
  Ints channel = talks ? in_use(g, all(0)) : all(SILENT);
  if (any(draws)) channel = draws ? randomly(g, jammer) : channel;
  if (any(sweeps)) channel = sweeps ? sweeping(g, jammer) : channel;
  return emitter.exists ? channel : all(SILENT);
}

}  // namespace slcs2
