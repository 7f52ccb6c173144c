// What a lane group holds: LANES episodes side by side, each array of vectors [..., LANES]. n agents, nodes: agents
// 0..n-1, source n, sink n + 1, then the jammers. See swarm/state.py, whose fields these are.
#pragma once
#include <cstddef>
#include <cstdlib>
#include <new>

#include "vector.h"

namespace slcs2 {

constexpr float SLACK = 1e-3f;  // m: what is nearer to a limit than this meets it (world/geometry.py)
constexpr int UNKNOWN = -1;
constexpr int WORD = 32;      // agents per word of a packet's history
constexpr int HISTORY = 32;   // steps that a rule's trace holds
constexpr int CLAUSE_WORDS = 4;
constexpr int MOST_AGENTS = 64, MOST_NODES = MOST_AGENTS + 2, MOST_CHANNELS = 14;
constexpr int MOST_JAMMERS = 16, MOST_POINTS = 16, MOST_BODIES = MOST_NODES + MOST_JAMMERS;

enum Policy : int32_t { CLASSIFIER, FIRST_MATCH };
enum Fading : int32_t { NO_FADING, LOG_NORMAL, RAYLEIGH, RICIAN, NAKAGAMI };

// Sizes that all episodes of a call have in common; the order is that of `arrays.py`.
struct Sizes {
  int32_t batch, agents, rules, words, channels, vertical, horizontal;
  int32_t period;   // steps between exchanges of knowledge
  int32_t round;    // steps between settlements of strength, a divisor of the period
  int32_t depth;    // BP_max
  int32_t periods;  // to compute
  int32_t policy, fading;
  int32_t reflexes;    // whether rules can be reflexes
  int32_t noted;       // whether to write down every step of the first episode
  int32_t vocabulary;  // channels that actions can name
  int32_t jammers;     // J, where they are more than the paper's one that stays and answers; else 0
  int32_t points;      // P, of a jammer's route
  int32_t failing;     // whether agents can fail
  int32_t keeps;       // whether the packet of a failing agent stays with it
  int32_t failures;    // how many times there are at which agents fail

  int nodes() const { return agents + 2; }
  int places() const { return agents + 3; }              // of the table of links: nodes and the first jammer
  int bodies() const { return nodes() + shown_jammers(); }  // nodes and all jammers
  int further_jammers() const { return shown_jammers() - 1; }
  int shown_jammers() const { return jammers > 0 ? jammers : 1; }
  int history_words() const { return (agents + WORD - 1) / WORD; }
  int rule_words() const { return (rules + 63) / 64; }
  int set_words() const { return (rules + WORD - 1) / WORD; }  // of an action set in XLA's arrays
  int steps() const { return periods * period; }
};

// The values that an episode is computed with; the order is that of `arrays.py`.
struct Parameters {
  Floats fading;  // its parameter: sigma in powers of two, K, or m
  Floats gain, slope, floor, wall;
  Floats noise, sensitivity, threshold, half_power, network_range;
  Floats packets, speed, clearance, clear, lidar_range, distance_threshold, tolerance, half_thickness;
  Floats cost_move, cost_communicate;
  Floats alpha_grasp, alpha_q, alpha_q_final, beta_q, trace_decay;
  Floats failure_rate, recovery_rate, failure_count;

  static constexpr size_t COUNT = 28;

  void set(size_t number, Floats value) { memcpy((char*)this + number * sizeof value, &value, sizeof value); }
};
static_assert(sizeof(Parameters) == Parameters::COUNT * sizeof(Floats), "");

// Memory in one block, given out in pieces that are aligned for vectors. Without a block it only counts.
class Store {
 public:
  Store() = default;
  explicit Store(size_t size) : block_((char*)std::aligned_alloc(ALIGNMENT, size)) {
    if (block_ == nullptr) throw std::bad_alloc();
  }
  ~Store() { std::free(block_); }
  Store(const Store&) = delete;
  Store& operator=(const Store&) = delete;

  template <class T>
  T* take(size_t count) {
    T* piece = block_ == nullptr ? nullptr : (T*)(block_ + used_);
    used_ += (count * sizeof(T) + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    return piece;
  }
  size_t used() const { return used_; }

 private:
  static constexpr size_t ALIGNMENT = 64;
  char* block_ = nullptr;
  size_t used_ = 0;
};

// What an agent means by its action (swarm/intent.py).
struct Intent {
  Mask acts, moves, collects, sends, place_known, to_obstacle;
  Ints direction, node, channel;
  Floats place_x, place_y, level;
};

// A jammer as it is set (world/emitters.py); who does not exist is silent. Places in m, speed in m per step.
struct Emitter {
  Mask exists;
  Ints emission, motion, dwell;
  Floats level, speed, duty;
  Floats route_x[MOST_POINTS], route_y[MOST_POINTS];
};

// The given world, and the state of the episodes. Tables of pairs are [self][other]: all that an agent needs is together.
struct Group {
  const Sizes& sizes;
  Parameters parameters;
  const int n, nodes, places, bodies, channels;

  Floats sink_x, sink_y, estimate_x, estimate_y, jammer_x, jammer_y;
  Mask has_jammer, channel_used[MOST_CHANNELS];
  Ints time_limit;
  bool any_jammer;
  Emitter* emitters;             // [J]
  int jammers_present;           // how many of them there are in any lane, the absent ones before the last included
  Ints* failures_at;             // [failures], time-steps

  Ints t, waiting, delivered;
  Words key_low, key_high;
  Mask running;
  Floats *x, *y;                 // [bodies]
  Floats* power;                 // [bodies, places], mW at full power; of further jammers only to nodes
  Ints* known_time;              // [n self, n other]
  Floats *known_x, *known_y;     // [n self, n other]
  Mask* heard;                   // [n self, nodes]
  Floats* jammer_range;          // [n]
  Mask* holding;                 // [n]
  Words* history;                // [n, history words]
  Ints* contribution;            // [n]
  Floats* interference;          // [n, channels]
  Floats* reward;                // [n]
  Floats* recent;                // [n, depth], the latest first
  Floats* gains;                 // [n, round], of the steps since the last settlement
  Ints* seen_time;               // [J, n], an agent's news of a jammer
  Floats *seen_x, *seen_y, *seen_range;
  Mask* down;                    // [n]
  Ints lost = all(0);

  Floats* jamming;               // [channels, nodes], of this step
  Floats* disturbance;           // [nodes], jamming on the channel in use that is the best there
  Ints* emits;                   // [J], the channel that each jammer transmits on
  Floats* noise;                 // [J, nodes], what is received of each
  Floats *believed_x, *believed_y;  // [n], where each agent believes the jammer to be that is the nearest to it
  Floats *to_sink, *to_source;   // [n], m, before the step
  Intent* intent;                // [n]
  Ints* told_time;               // [n self, n other], room for the next knowledge
  Floats *told_x, *told_y;
  Ints* told_seen_time;          // [J, n], the same for the jammers
  Floats *told_seen_x, *told_seen_y, *told_seen_range;

  Group(const Sizes& s, Store& store)
      : sizes(s), n(s.agents), nodes(s.nodes()), places(s.places()), bodies(s.bodies()),
        channels(s.channels) {
    const size_t pairs = (size_t)n * n;
    x = store.take<Floats>(bodies), y = store.take<Floats>(bodies);
    power = store.take<Floats>((size_t)bodies * places);
    known_time = store.take<Ints>(pairs), known_x = store.take<Floats>(pairs), known_y = store.take<Floats>(pairs);
    told_time = store.take<Ints>(pairs), told_x = store.take<Floats>(pairs), told_y = store.take<Floats>(pairs);
    heard = store.take<Mask>((size_t)n * nodes);
    jammer_range = store.take<Floats>(n), holding = store.take<Mask>(n);
    history = store.take<Words>((size_t)n * s.history_words()), contribution = store.take<Ints>(n);
    interference = store.take<Floats>((size_t)n * channels), reward = store.take<Floats>(n);
    recent = store.take<Floats>((size_t)n * s.depth), gains = store.take<Floats>((size_t)n * s.round);
    jamming = store.take<Floats>((size_t)channels * nodes), disturbance = store.take<Floats>(nodes);
    to_sink = store.take<Floats>(n), to_source = store.take<Floats>(n), intent = store.take<Intent>(n);
    down = store.take<Mask>(s.failing ? n : 0), failures_at = store.take<Ints>(s.failures);
    emitters = store.take<Emitter>(s.jammers), emits = store.take<Ints>(s.jammers);
    noise = store.take<Floats>((size_t)s.jammers * nodes);
    const size_t news = (size_t)s.jammers * n;
    for (Ints** table : {&seen_time, &told_seen_time}) *table = store.take<Ints>(news);
    for (Floats** table : {&seen_x, &seen_y, &seen_range, &told_seen_x, &told_seen_y, &told_seen_range})
      *table = store.take<Floats>(news);
    for (Floats** place : {&believed_x, &believed_y}) *place = store.take<Floats>(s.jammers > 0 ? n : 0);
  }

  Floats* power_of(int node) { return power + (size_t)node * places; }
  const Floats* power_of(int node) const { return power + (size_t)node * places; }
};

// Packets are under way and time is left (swarm/task.py, Delivery).
inline Mask is_running(const Group& g) {
  return (g.delivered + g.lost < __builtin_convertvector(g.parameters.packets, Ints)) & (g.t < g.time_limit);
}

}  // namespace slcs2
