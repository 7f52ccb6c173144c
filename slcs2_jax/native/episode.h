// Episodes, step after step. See episode.py and swarm/step.py; here they are computed a lane group at a time, and in each
// step agent by agent as far as nobody else's doings matter.
#pragma once
#include <optional>

#include "classifier.h"
#include "first_match.h"
#include "intent.h"
#include "knowledge.h"
#include "links.h"
#include "motion.h"
#include "notes.h"
#include "observation.h"
#include "packets.h"
#include "reward.h"
#include "strength.h"
#include "transpose.h"

namespace slcs2 {

// All that it takes to compute a lane group.
class Simulation {
 public:
  Simulation(const Sizes& s, Store& store)
      : sizes_(s), group_(s, store), crossings_(s.nodes(), s.bodies(), store),
        candidates_(store.take<Candidates>(1)), traffic_(store.take<Traffic>(1)), motion_(store.take<Motion>(1)),
        walls_(store.take<Walls>(1)), names_(store.take<uint32_t>(s.agents * Mind::whole_vectors(s))),
        minds_(store.take<Mind>((size_t)s.agents * LANES)) {
    for (int lane = 0; lane < LANES; lane++) {
      const Lines vertical = Lines::take(store, s.vertical), horizontal = Lines::take(store, s.horizontal);
      if (walls_ != nullptr) walls_->vertical[lane] = vertical, walls_->horizontal[lane] = horizontal;
    }
    for (int k = 0; k < s.agents * LANES; k++) {
      const Mind mind = Mind::take(store, s);
      if (minds_ != nullptr) minds_[k] = mind;
    }
    for (int i = 0; names_ != nullptr && i < s.agents; i++)
      for (size_t r = 0; r < Mind::whole_vectors(s); r++)
        names_[i * Mind::whole_vectors(s) + r] = ((uint32_t)r * s.agents + i) * GOLDEN;
  }

  // Compute `periods` sharing periods for LANES episodes of the batch from `begin` on. Episodes that are over when it
  // begins stay as they are; those that end on the way stand still from then on.
  void advance(const Buffers& buffers, int begin) {
    const Rows rows(sizes_.batch, begin);
    std::optional<Notes> notes;
    if (sizes_.noted && begin == 0) notes.emplace(sizes_, buffers);
    load_world(buffers, rows, group_);
    load_state(buffers, rows, group_);
    const Mask running = is_running(group_);
    if (!any(running)) return;
    for (int lane = 0; lane < LANES; lane++) awake_[lane] = running[lane] != 0;
    begin_minds(buffers, rows);
    load_walls(buffers, sizes_, rows, begin, *walls_);
    play(notes ? &*notes : nullptr);
    store_state(buffers, rows, group_, awake_);
    for (int i = 0; i < group_.n; i++) store_minds(buffers, rows, i, minds_ + i * LANES, awake_, sizes_.steps());
  }

  // The figures of episodes that are over (policy/classifier.py, finish): the last action learnt with nothing ahead,
  // strength divided by usage.
  void finish(const Buffers& buffers, int begin) {
    const Rows rows(sizes_.batch, begin);
    load_world(buffers, rows, group_);
    load_state(buffers, rows, group_);
    for (int lane = 0; lane < LANES; lane++) awake_[lane] = lane < rows.count();
    begin_minds(buffers, rows);
    const Floats alpha = learning_rate();
    each_mind([&](int i, int lane, Mind& mind) {
      learn(mind, mind.set(HISTORY - 1), group_.reward[i][lane], 0.0f, alpha[lane], group_.parameters.beta_q[lane]);
      memset(mind.set(0), 0, mind.words * sizeof(Bits));
      float recent[HISTORY];
      for (int k = 0; k < sizes_.depth; k++) recent[k] = group_.recent[(size_t)i * sizes_.depth + k][lane];
      finish_strength(mind, recent, HISTORY - 1, group_.parameters.trace_decay[lane]);
    });
    for (int i = 0; i < group_.n; i++) store_minds(buffers, rows, i, minds_ + i * LANES, awake_, 1);
  }

 private:
  template <class Visit>
  void each_mind(Visit visit) {
    for (int i = 0; i < group_.n; i++)
      for (int lane = 0; lane < LANES; lane++)
        if (awake_[lane]) visit(i, lane, minds_[i * LANES + lane]);
  }

  void begin_minds(const Buffers& buffers, const Rows& rows) {
    memset(needed_, 0, sizeof needed_);
    for (int i = 0; i < group_.n; i++) load_minds(buffers, rows, i, minds_ + i * LANES, awake_);
    each_mind([&](int, int, Mind& mind) {
      mind.begin();
      for (int r = 0; r < sizes_.rules; r++)
        for (int w = 0; w < sizes_.words; w++) needed_[w] |= mind.condition[w * Mind::whole_vectors(sizes_) + r];
    });
  }

  void play(Notes* notes) {
    crossings_.reset();
    draw_links();
    int step = 0;
    for (int period = 0; period < sizes_.periods; period++) {
      for (int k = 0; k < sizes_.period; k++, step++) {
        one_step(step, notes);
        const int place = step % sizes_.round;
        for (int i = 0; i < group_.n; i++)
          group_.gains[(size_t)i * sizes_.round + place] = gain(group_.reward[i], group_.intent[i].acts);
        if (place == sizes_.round - 1 && sizes_.policy == CLASSIFIER) settle(group_, minds_, awake_, step);
      }
      share(group_);
    }
    draw(group_, has_walls() ? &crossings_ : nullptr, true);  // all jammers' links, as others expect them
  }

  void one_step(int step, Notes* notes) {
    Group& g = group_;
    measure(g);
    g.running = is_running(g);
    if (notes) notes->before(g, step);
    const Floats alpha = learning_rate();
    const Stream<Words> lots = stream(g.key_low, g.key_high, g.t, RULE);
    for (int i = 0; i < g.n; i++) {
      enter_neighbours(g, i);
      find_candidates(g, i, *candidates_);
      const Truth truth = observe(g, i, *candidates_, needed_);
      interpret(g, i, decide_all(i, step, truth, alpha, lots, notes), *candidates_);
    }
    const Walls* walls = has_walls() ? walls_ : nullptr;
    find_obstacles(g, walls);
    transfer(g, *traffic_);
    if (notes) notes->traffic(g, step, *traffic_);
    move_jammers(g);
    move(g, walls, *motion_);
    g.t -= g.running;
    draw_links();
    if (sizes_.failing) fail(g, g.running);
    reward_agents(g, *traffic_);
  }

  // What agent i does in every episode.
  Ints decide_all(int i, int step, const Truth& truth, Floats alpha, const Stream<Words>& lots, Notes* notes) {
    const bool learns = sizes_.policy == CLASSIFIER;
    const uint32_t* names = names_ + i * Mind::whole_vectors(sizes_);
    Mind* minds = minds_ + i * LANES;
    Ints action = all(NO_ACTION);
    for (int lane = 0; lane < LANES; lane++) {
      if (!awake_[lane]) continue;
      uint32_t clauses[CLAUSE_WORDS];
      for (int w = 0; w < CLAUSE_WORDS; w++) clauses[w] = truth.word[w][lane];
      minds[lane].see(clauses);
      if (!learns) action[lane] = decide_by_list(minds[lane]);
    }
    if (learns) action = decide(minds, awake_, step, names, group_.reward[i], alpha, group_.parameters, lots);
    if (sizes_.failing) action = group_.down[i] ? all(NO_ACTION) : action;
    if (notes) {
      const float width = group_.parameters.alpha_grasp[0];
      const int rule = learns ? chosen(*minds, names, width, in_lane(lots, 0)) : minds->first_match();
      notes->decision(step, i, *minds, action[0], rule);
    }
    return action;
  }

  // alpha_q at the last step's share of the time limit: linearly from first to final value (policy/learning.py).
  Floats learning_rate() const {
    const Parameters& p = group_.parameters;
    const Ints limit = group_.time_limit > 1 ? group_.time_limit : all(1);
    const Floats last = maximum(__builtin_convertvector(group_.t - 1, Floats), all(0.0f));
    const Floats share = minimum(last / __builtin_convertvector(limit, Floats), all(1.0f));
    return (p.alpha_q - p.alpha_q_final) * (1.0f - share) + p.alpha_q_final;
  }

  void draw_links() {
    if (has_walls()) crossings_.update(group_, *walls_);
    draw(group_, has_walls() ? &crossings_ : nullptr, group_.any_jammer);
  }

  bool has_walls() const { return sizes_.vertical + sizes_.horizontal > 0; }

  const Sizes& sizes_;
  Group group_;
  Crossings crossings_;
  Candidates* candidates_;
  Traffic* traffic_;
  Motion* motion_;
  Walls* walls_;
  uint32_t* names_;  // [n, R], of the rules in the whole swarm, for their draws
  Mind* minds_;      // [n, LANES]
  bool awake_[LANES];
  uint32_t needed_[CLAUSE_WORDS];
};

}  // namespace slcs2
