// The arrays of a call, as XLA lays them out: [..., batch], the batch last. Names and shapes are those of world/arena.py,
// policy/classifier.py, swarm/state.py and looking/recording.py; the order is that of `arrays.py`.
// Of parts that a call does without the arrays are empty.
#pragma once
#include "mind.h"
#include "state.h"

namespace slcs2 {

enum Given {
  SINK_X, SINK_Y, ESTIMATE_X, ESTIMATE_Y, JAMMER_X, JAMMER_Y, HAS_JAMMER, TIME_LIMIT, CHANNELS,
  VERTICAL_AT, VERTICAL_LOW, VERTICAL_HIGH, HORIZONTAL_AT, HORIZONTAL_LOW, HORIZONTAL_HIGH, CONDITION, ACTION,
  REFLEX, EXISTS, ROUTE_X, ROUTE_Y, EMISSION_KIND, MOTION_KIND, LEVEL, SPEED, DUTY, DWELL, FAILURES_AT,
  VALUES, GIVEN
};
enum Kept {
  T, KEY, NODE_X, NODE_Y, POWER, KNOWN_TIME, KNOWN_X, KNOWN_Y, HEARD, JAMMER_RANGE_, HOLDING, HISTORY_, WAITING,
  DELIVERED, CONTRIBUTION, INTERFERENCE, JAMMERS_X, JAMMERS_Y, JAMMERS_POWER, SEEN_TIME, SEEN_X, SEEN_Y, SEEN_RANGE,
  DOWN, LOST, STATE,
  USAGE = STATE, QUALITY, ERROR, STRENGTH, TRACE, MEMBERS, REWARD, RECENT, KEPT,
  KEPT_BY_LIST = USAGE + 1  // all that a decision list keeps
};
enum Noted {
  N_RUNNING, N_X, N_Y, N_HOLDING, N_WAITING, N_DELIVERED, N_HEARD, N_JAMMED, N_ACTION, N_RULE, N_SENT_TO, N_SENT_FATE,
  N_SERVED, N_SERVED_FATE, N_JAMMER_X, N_JAMMER_Y, N_DOWN, N_MATCHED, NOTED
};

struct Buffers {
  const void* given[GIVEN];
  void* kept[KEPT];
  void* noted[NOTED];
};

inline int kept_buffers(const Sizes& s) { return s.policy == CLASSIFIER ? (int)KEPT : (int)KEPT_BY_LIST; }

// Bytes of each array: what a caller must bring.
inline size_t given_bytes(const Sizes& s, int which) {
  const size_t b = s.batch, lanes = 4 * b;
  switch (which) {
    case HAS_JAMMER: return b;
    case CHANNELS: return s.channels * b;
    case VERTICAL_AT: case VERTICAL_LOW: case VERTICAL_HIGH: return s.vertical * lanes;
    case HORIZONTAL_AT: case HORIZONTAL_LOW: case HORIZONTAL_HIGH: return s.horizontal * lanes;
    case CONDITION: return (size_t)s.words * s.rules * s.agents * lanes;
    case ACTION: return (size_t)s.rules * s.agents * b;
    case REFLEX: return s.reflexes ? (size_t)s.rules * s.agents * b : 0;
    case EXISTS: return s.jammers * b;
    case ROUTE_X: case ROUTE_Y: return (size_t)s.points * s.jammers * lanes;
    case EMISSION_KIND: case MOTION_KIND: case LEVEL: case SPEED: case DUTY: case DWELL: return s.jammers * lanes;
    case FAILURES_AT: return s.failures * lanes;
    case VALUES: return Parameters::COUNT * lanes;
    default: return lanes;
  }
}

inline size_t kept_bytes(const Sizes& s, int which) {
  const size_t b = s.batch, lanes = 4 * b, n = s.agents;
  switch (which) {
    case T: case WAITING: case DELIVERED: return lanes;
    case KEY: return 2 * lanes;
    case NODE_X: case NODE_Y: return s.places() * lanes;
    case POWER: return (size_t)((s.places() + 1) / 2) * s.places() * lanes;
    case KNOWN_TIME: case KNOWN_X: case KNOWN_Y: return n * n * lanes;
    case HEARD: return s.nodes() * n * b;
    case HOLDING: return n * b;
    case DOWN: return s.failing ? n * b : 0;
    case LOST: return s.failing ? lanes : 0;
    case JAMMERS_X: case JAMMERS_Y: return s.further_jammers() * lanes;
    case JAMMERS_POWER: return (size_t)s.further_jammers() * s.nodes() * lanes;
    case SEEN_TIME: case SEEN_X: case SEEN_Y: case SEEN_RANGE: return s.jammers * n * lanes;
    case HISTORY_: return s.history_words() * n * lanes;
    case INTERFERENCE: return s.channels * n * lanes;
    case JAMMER_RANGE_: case CONTRIBUTION: case REWARD: return n * lanes;
    case MEMBERS: return s.set_words() * n * lanes;
    case RECENT: return s.depth * n * lanes;
    default: return s.rules * n * lanes;
  }
}

inline size_t noted_bytes(const Sizes& s, int which) {
  const size_t steps = s.steps(), n = s.agents;
  switch (which) {
    case N_RUNNING: return steps;
    case N_JAMMED: return steps * s.shown_jammers();
    case N_JAMMER_X: case N_JAMMER_Y: return 4 * steps * s.shown_jammers();
    case N_X: case N_Y: return 4 * steps * n;
    case N_WAITING: case N_DELIVERED: return 4 * steps;
    case N_HEARD: return 4 * steps * ((s.nodes() + WORD - 1) / WORD) * n;
    case N_RULE: return 2 * steps * n;
    case N_SERVED: case N_SERVED_FATE: return steps * s.channels;
    case N_MATCHED: return 4 * (size_t)s.rules * n;
    default: return steps * n;
  }
}

}  // namespace slcs2
