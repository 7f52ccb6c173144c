// From XLA's arrays [..., batch] into a lane group and back. Lanes beyond the batch hold an episode without time.
#pragma once
#include "buffers.h"
#include "geometry.h"
#include "mind.h"
#include "state.h"

namespace slcs2 {

// The rows of one lane group: `count` episodes of the batch from `begin` on.
class Rows {
 public:
  Rows(int batch, int begin) : batch_(batch), begin_(begin), count_(std::min(LANES, batch - begin)) {}

  int count() const { return count_; }

  template <class V, class E = std::remove_reference_t<decltype(V{}[0])>>
  V load(const void* array, size_t row) const {
    V vector{};
    memcpy(&vector, (const E*)array + row * batch_ + begin_, count_ * sizeof(E));
    return vector;
  }

  Mask load_mask(const void* array, size_t row) const {
    Mask holds{};
    const char* from = (const char*)array + row * batch_ + begin_;
    for (int lane = 0; lane < count_; lane++) holds[lane] = from[lane] ? -1 : 0;
    return holds;
  }

  // Only the lanes that are awake: the others stay as they are in the array.
  template <class V, class E = std::remove_reference_t<decltype(V{}[0])>>
  void store(void* array, size_t row, const V& vector, const bool* awake) const {
    E* to = (E*)array + row * batch_ + begin_;
    for (int lane = 0; lane < count_; lane++)
      if (awake[lane]) to[lane] = vector[lane];
  }

  void store_mask(void* array, size_t row, Mask holds, const bool* awake) const {
    char* to = (char*)array + row * batch_ + begin_;
    for (int lane = 0; lane < count_; lane++)
      if (awake[lane]) to[lane] = holds[lane] ? 1 : 0;
  }

  template <class E>
  E& at(void* array, size_t row, int lane) const {
    return ((E*)array)[row * batch_ + begin_ + lane];
  }

  template <class E>
  const E& at(const void* array, size_t row, int lane) const {
    return ((const E*)array)[row * batch_ + begin_ + lane];
  }

 private:
  const size_t batch_, begin_;
  const int count_;
};

// Those that exist in no lane come last, and are left out; numbers of lanes beyond the batch are made harmless.
inline void load_emitters(const Buffers& buffers, const Rows& rows, Group& g) {
  const void* const* from = buffers.given;
  g.any_jammer = any(g.has_jammer), g.jammers_present = 0;
  const int jammers = g.sizes.jammers;
  for (int j = 0; j < jammers; j++) {
    Emitter& emitter = g.emitters[j];
    emitter.exists = rows.load_mask(from[EXISTS], j);
    emitter.emission = rows.load<Ints>(from[EMISSION_KIND], j), emitter.motion = rows.load<Ints>(from[MOTION_KIND], j);
    emitter.level = rows.load<Floats>(from[LEVEL], j), emitter.speed = rows.load<Floats>(from[SPEED], j);
    emitter.duty = rows.load<Floats>(from[DUTY], j), emitter.dwell = rows.load<Ints>(from[DWELL], j);
    emitter.dwell = emitter.dwell > 1 ? emitter.dwell : all(1);
    for (int k = 0; k < g.sizes.points; k++) {
      emitter.route_x[k] = rows.load<Floats>(from[ROUTE_X], (size_t)k * jammers + j);
      emitter.route_y[k] = rows.load<Floats>(from[ROUTE_Y], (size_t)k * jammers + j);
    }
    if (any(emitter.exists)) g.jammers_present = j + 1, g.any_jammer = true;
  }
}

inline void load_world(const Buffers& buffers, const Rows& rows, Group& g) {
  const void* const* from = buffers.given;
  g.sink_x = rows.load<Floats>(from[SINK_X], 0), g.sink_y = rows.load<Floats>(from[SINK_Y], 0);
  g.estimate_x = rows.load<Floats>(from[ESTIMATE_X], 0), g.estimate_y = rows.load<Floats>(from[ESTIMATE_Y], 0);
  g.jammer_x = rows.load<Floats>(from[JAMMER_X], 0), g.jammer_y = rows.load<Floats>(from[JAMMER_Y], 0);
  g.has_jammer = rows.load_mask(from[HAS_JAMMER], 0);
  g.time_limit = rows.load<Ints>(from[TIME_LIMIT], 0);
  for (int c = 0; c < g.channels; c++) g.channel_used[c] = rows.load_mask(from[CHANNELS], c);
  for (int k = 0; k < g.sizes.failures; k++) g.failures_at[k] = rows.load<Ints>(from[FAILURES_AT], k);
  for (size_t k = 0; k < Parameters::COUNT; k++) g.parameters.set(k, rows.load<Floats>(from[VALUES], k));
  load_emitters(buffers, rows, g);
}

// Move every field of the state: from the arrays into the group, or back. `move(array, row, vector)`.
template <class MoveVector, class MoveMask>
inline void each_field(const Buffers& buffers, Group& g, MoveVector move, MoveMask move_mask) {
  void* const* arrays = buffers.kept;
  const int n = g.n, words = g.sizes.history_words();
  move(arrays[T], 0, g.t), move(arrays[WAITING], 0, g.waiting), move(arrays[DELIVERED], 0, g.delivered);
  move(arrays[KEY], 0, g.key_low), move(arrays[KEY], 1, g.key_high);
  for (int k = 0; k < g.places; k++) move(arrays[NODE_X], k, g.x[k]), move(arrays[NODE_Y], k, g.y[k]);
  for (int i = 0; i < n; i++) {
    for (int j = 0; j < n; j++) {
      const size_t row = (size_t)j * n + i, pair = (size_t)i * n + j;
      move(arrays[KNOWN_TIME], row, g.known_time[pair]);
      move(arrays[KNOWN_X], row, g.known_x[pair]), move(arrays[KNOWN_Y], row, g.known_y[pair]);
    }
    for (int j = 0; j < g.nodes; j++) move_mask(arrays[HEARD], (size_t)j * n + i, g.heard[(size_t)i * g.nodes + j]);
    move(arrays[JAMMER_RANGE_], i, g.jammer_range[i]), move_mask(arrays[HOLDING], i, g.holding[i]);
    for (int w = 0; w < words; w++) move(arrays[HISTORY_], (size_t)w * n + i, g.history[(size_t)i * words + w]);
    move(arrays[CONTRIBUTION], i, g.contribution[i]);
    for (int c = 0; c < g.channels; c++)
      move(arrays[INTERFERENCE], (size_t)c * n + i, g.interference[(size_t)i * g.channels + c]);
    if (g.sizes.failing) move_mask(arrays[DOWN], i, g.down[i]);
    if (g.sizes.policy != CLASSIFIER) continue;
    move(arrays[REWARD], i, g.reward[i]);
    for (int k = 0; k < g.sizes.depth; k++)
      move(arrays[RECENT], (size_t)k * n + i, g.recent[(size_t)i * g.sizes.depth + k]);
  }
  if (g.sizes.failing) move(arrays[LOST], 0, g.lost);
  for (int j = 0; j < g.sizes.further_jammers(); j++)
    move(arrays[JAMMERS_X], j, g.x[g.places + j]), move(arrays[JAMMERS_Y], j, g.y[g.places + j]);
  for (int k = 0; k < g.sizes.jammers * n; k++) {
    move(arrays[SEEN_TIME], k, g.seen_time[k]), move(arrays[SEEN_X], k, g.seen_x[k]);
    move(arrays[SEEN_Y], k, g.seen_y[k]), move(arrays[SEEN_RANGE], k, g.seen_range[k]);
  }
}

inline void load_state(const Buffers& buffers, const Rows& rows, Group& g) {
  each_field(
      buffers, g,
      [&](const void* array, size_t row, auto& vector) {
        vector = rows.load<std::remove_reference_t<decltype(vector)>>(array, row);
      },
      [&](const void* array, size_t row, Mask& holds) { holds = rows.load_mask(array, row); });
}

// The links of the step to come, folded (swarm/links.py): row r holds the links (r, c) for c > r and, in the room that
// these leave, the links of row count - 1 - r turned round.
inline void store_power(const Buffers& buffers, const Rows& rows, const Group& g, const bool* awake) {
  const int last = g.places - 1;
  for (int r = 0; r < (g.places + 1) / 2; r++)
    for (int c = 0; c < g.places; c++) {
      const int i = c >= r ? r : last - r, j = c >= r ? c : last - c;
      rows.store(buffers.kept[POWER], (size_t)r * g.places + c, g.power_of(i)[j], awake);
    }
  for (int jammer = 0; jammer < g.sizes.further_jammers(); jammer++)
    for (int i = 0; i < g.nodes; i++)
      rows.store(buffers.kept[JAMMERS_POWER], (size_t)jammer * g.nodes + i, g.power_of(g.places + jammer)[i], awake);
}

inline void store_state(const Buffers& buffers, const Rows& rows, Group& g, const bool* awake) {
  each_field(
      buffers, g, [&](void* array, size_t row, auto& vector) { rows.store(array, row, vector, awake); },
      [&](void* array, size_t row, Mask holds) { rows.store_mask(array, row, holds, awake); });
  store_power(buffers, rows, g, awake);
}

// Agent i's rules and memory in all episodes that are awake. Bit k of a trace tells whether the rule was in the action set
// k steps ago; usage counts all of these sets, a classifier's mind has yet to count the last one. That is in the members,
// too, in stretches of rules (policy/bits.py). minds: [LANES].
inline void load_minds(const Buffers& buffers, const Rows& rows, int i, Mind* minds, const bool* awake) {
  const Sizes& s = *minds->sizes;
  const size_t room = Mind::whole_vectors(s);
  const bool learns = s.policy == CLASSIFIER;
  const void* const* kept = buffers.kept;
  for (int lane = 0; lane < rows.count(); lane++) {
    memset(minds[lane].sets, 0, HISTORY * (size_t)minds[lane].words * sizeof(Bits));
    if (s.reflexes) memset(minds[lane].reflex, 0, minds[lane].words * sizeof(Bits));
  }
  for (int r = 0; r < s.rules; r++)
    for (int lane = 0; lane < rows.count(); lane++) {
      if (!awake[lane]) continue;
      const size_t row = (size_t)r * s.agents + i;
      const Mind& mind = minds[lane];
      for (int w = 0; w < s.words; w++)
        mind.condition[w * room + r] =
            rows.at<uint32_t>(buffers.given[CONDITION], (size_t)w * s.rules * s.agents + row, lane);
      if (s.reflexes && rows.at<uint8_t>(buffers.given[REFLEX], row, lane))
        mind.reflex[r / 64] |= Bits(1) << (r % 64);
      mind.action[r] = rows.at<uint8_t>(buffers.given[ACTION], row, lane);
      mind.usage[r] = rows.at<int32_t>(kept[USAGE], row, lane);
      mind.quality[r] = 0.0f;
      if (!learns) continue;
      const uint32_t trace = rows.at<uint32_t>(kept[TRACE], row, lane);
      mind.quality[r] = rows.at<float>(kept[QUALITY], row, lane);
      mind.error[r] = rows.at<float>(kept[ERROR], row, lane);
      mind.strength[r] = rows.at<float>(kept[STRENGTH], row, lane);
      mind.usage[r] -= (int32_t)(trace & 1);
      for (uint32_t left = trace; left; left &= left - 1)
        mind.set(HISTORY - 1 - __builtin_ctz(left))[r / 64] |= Bits(1) << (r % 64);
    }
}

// `steps`: how many were made since the minds were loaded.
inline void store_minds(const Buffers& buffers, const Rows& rows, int i, const Mind* minds, const bool* awake,
                        int steps) {
  const Sizes& s = *minds->sizes;
  const bool learns = s.policy == CLASSIFIER;
  void* const* kept = buffers.kept;
  const auto members = [&](int word, int lane) -> uint32_t& {
    return rows.at<uint32_t>(kept[MEMBERS], (size_t)word * s.agents + i, lane);
  };
  for (int r = 0; r < s.rules; r++)
    for (int lane = 0; lane < rows.count(); lane++) {
      if (!awake[lane]) continue;
      const size_t row = (size_t)r * s.agents + i;
      const Mind& mind = minds[lane];
      rows.at<int32_t>(kept[USAGE], row, lane) = mind.usage[r];
      if (!learns) continue;
      rows.at<float>(kept[QUALITY], row, lane) = mind.quality[r];
      rows.at<float>(kept[ERROR], row, lane) = mind.error[r];
      rows.at<float>(kept[STRENGTH], row, lane) = mind.strength[r];
      rows.at<uint32_t>(kept[TRACE], row, lane) = 0;
    }
  const int stretch = (s.rules + s.set_words() - 1) / s.set_words();
  for (int lane = 0; learns && lane < rows.count(); lane++) {
    for (int w = 0; awake[lane] && w < s.set_words(); w++) members(w, lane) = 0;
    for (int k = 0; awake[lane] && k < HISTORY; k++)
      for_each(minds[lane].set(steps % HISTORY + HISTORY - 1 - k), minds[lane].words, [&](int r) {
        const size_t row = (size_t)r * s.agents + i;
        rows.at<uint32_t>(kept[TRACE], row, lane) |= 1u << k;
        if (k > 0) return;
        rows.at<int32_t>(kept[USAGE], row, lane)++;
        members(r / stretch, lane) |= 1u << (r % stretch);
      });
  }
}

inline void load_walls(const Buffers& buffers, const Sizes& s, const Rows& rows, int begin, Walls& walls) {
  const auto table = [&](int which) { return (const float*)buffers.given[which]; };
  for (int lane = 0; lane < LANES; lane++) {
    const bool real = lane < rows.count();
    walls.vertical[lane].fill(table(VERTICAL_AT), table(VERTICAL_LOW), table(VERTICAL_HIGH), real ? s.vertical : 0,
                              s.batch, begin + lane);
    walls.horizontal[lane].fill(table(HORIZONTAL_AT), table(HORIZONTAL_LOW), table(HORIZONTAL_HIGH),
                                real ? s.horizontal : 0, s.batch, begin + lane);
  }
}

}  // namespace slcs2
