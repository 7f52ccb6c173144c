// Agents that fail and recover. See swarm/failure.py and swarm/state.py.
#pragma once
#include "randomness.h"
#include "state.h"

namespace slcs2 {

// Nothing is received from those that are down, nor by them.
inline void silence(Group& g) {
  for (int i = 0; i < g.n; i++) {
    if (!any(g.down[i])) continue;
    for (int j = 0; j < g.places; j++) g.power_of(i)[j] = where(~g.down[i], g.power_of(i)[j]);
    for (int j = 0; j < g.bodies; j++) g.power_of(j)[i] = where(~g.down[i], g.power_of(j)[i]);
  }
}

// Whether agent i is among the `failure_count` drawn at random that fail in a time-step at which agents do.
inline Mask is_drawn(const Group& g, int i, const Words* lots) {
  Ints before = all(0);
  for (int j = 0; j < g.n; j++) before -= (lots[j] < lots[i]) | (j < i ? lots[j] == lots[i] : mask(false));
  return before < __builtin_convertvector(g.parameters.failure_count, Ints);
}

// Who is down in time-step g.t, from who was in the one before, where the episode goes on.
inline void find_who_is_down(Group& g, Mask running) {
  const auto lots = [&](Purpose purpose) { return stream(g.key_low, g.key_high, g.t, purpose); };
  const Stream<Words> failure = lots(FAILURE), recovery = lots(RECOVERY);
  Mask due = mask(false);
  for (int k = 0; k < g.sizes.failures; k++) due |= g.t == g.failures_at[k];
  Words lot[MOST_AGENTS];
  const bool any_due = any(due);
  for (int i = 0; any_due && i < g.n; i++) lot[i] = lots(FAILURE_LOT).draw((uint32_t)i);
  for (int i = 0; i < g.n; i++) {
    const Mask fails = uniform(failure.draw((uint32_t)i)) < g.parameters.failure_rate;
    const Mask recovers = uniform(recovery.draw((uint32_t)i)) < g.parameters.recovery_rate;
    Mask down = g.down[i] ? ~recovers : fails;
    if (any_due) down |= due & is_drawn(g, i, lot);
    g.down[i] = running ? down : g.down[i];
  }
}

// The state with those down that do not work in time-step g.t, without the packets that they so lose.
inline void fail(Group& g, Mask running) {
  find_who_is_down(g, running);
  if (g.sizes.keeps) return;
  const int words = g.sizes.history_words();
  for (int i = 0; i < g.n; i++) {
    const Mask loses = g.down[i] & g.holding[i];
    if (!any(loses)) continue;
    g.holding[i] &= ~loses;
    g.lost -= loses;
    for (int w = 0; w < words; w++) g.history[(size_t)i * words + w] &= ~(Words)loses;
  }
}

}  // namespace slcs2
