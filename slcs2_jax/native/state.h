// What a lane group holds: LANES episodes side by side, each array of vectors [..., LANES]. n agents, nodes: agents
// 0..n-1, source n, sink n + 1, then the jammer. See swarm/state.py, whose fields these are.
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
constexpr int MOST_AGENTS = 64, MOST_NODES = MOST_AGENTS + 2, MOST_CHANNELS = 3;

enum Policy : int32_t { CLASSIFIER, FIRST_MATCH };
enum Fading : int32_t { NO_FADING, LOG_NORMAL };

// Sizes that all episodes of a call have in common; the order is that of `advance.py`.
struct Sizes {
  int32_t batch, agents, rules, words, channels, vertical, horizontal;
  int32_t period;   // steps between exchanges of knowledge
  int32_t round;    // steps between settlements of strength, a divisor of the period
  int32_t depth;    // BP_max
  int32_t periods;  // to compute
  int32_t policy, fading;
  int32_t reflexes;  // whether rules can be reflexes
  int32_t noted;     // whether to write down every step of the first episode

  int nodes() const { return agents + 2; }
  int places() const { return agents + 3; }
  int history_words() const { return (agents + WORD - 1) / WORD; }
  int rule_words() const { return (rules + 63) / 64; }
  int steps() const { return periods * period; }
};

// Scalars, all float32; the order is that of `advance.py`.
struct Parameters {
  float spread;  // of the fading: sigma in powers of two
  float gain, slope, floor, wall;
  float noise, sensitivity, threshold, half_power, network_range;
  float packets, speed, clearance, clear, lidar_range, distance_threshold, tolerance, half_thickness;
  float cost_move, cost_communicate;
  float alpha_grasp, alpha_q, alpha_q_final, beta_q, trace_decay;
};

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

// The given world, and the state of the episodes. Tables of pairs are [self][other]: all that an agent needs is together.
struct Group {
  const Sizes& sizes;
  const Parameters& parameters;
  const int n, nodes, places, channels;

  Floats sink_x, sink_y, estimate_x, estimate_y, jammer_x, jammer_y;
  Mask has_jammer, channel_used[MOST_CHANNELS];
  Ints time_limit;
  bool any_jammer;

  Ints t, waiting, delivered;
  Words key_low, key_high;
  Mask running;
  Floats *x, *y;                 // [places]
  Floats* power;                 // [places, places], mW at full power
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

  Floats* jamming;               // [channels, nodes], of this step
  Floats *to_sink, *to_source;   // [n], m, before the step
  Intent* intent;                // [n]
  Ints* told_time;               // [n self, n other], room for the next knowledge
  Floats *told_x, *told_y;

  Group(const Sizes& s, const Parameters& p, Store& store)
      : sizes(s), parameters(p), n(s.agents), nodes(s.nodes()), places(s.places()), channels(s.channels) {
    const size_t pairs = (size_t)n * n;
    x = store.take<Floats>(places), y = store.take<Floats>(places);
    power = store.take<Floats>((size_t)places * places);
    known_time = store.take<Ints>(pairs), known_x = store.take<Floats>(pairs), known_y = store.take<Floats>(pairs);
    told_time = store.take<Ints>(pairs), told_x = store.take<Floats>(pairs), told_y = store.take<Floats>(pairs);
    heard = store.take<Mask>((size_t)n * nodes);
    jammer_range = store.take<Floats>(n), holding = store.take<Mask>(n);
    history = store.take<Words>((size_t)n * s.history_words()), contribution = store.take<Ints>(n);
    interference = store.take<Floats>((size_t)n * channels), reward = store.take<Floats>(n);
    recent = store.take<Floats>((size_t)n * s.depth), gains = store.take<Floats>((size_t)n * s.round);
    jamming = store.take<Floats>((size_t)channels * nodes);
    to_sink = store.take<Floats>(n), to_source = store.take<Floats>(n), intent = store.take<Intent>(n);
  }

  Floats* power_of(int node) { return power + (size_t)node * places; }
  const Floats* power_of(int node) const { return power + (size_t)node * places; }
};

// Packets are under way and time is left (swarm/state.py, running).
inline Mask is_running(const Group& g) {
  return (g.delivered < (int32_t)g.parameters.packets) & (g.t < g.time_limit);
}

}  // namespace slcs2
