// Strength: each step's reward credited to the last BP_max + 1 action sets (paper, strength equation). See
// policy/strength.py: a set is credited BP_max steps later, with the sum of its credits, a whole round at a time.
#pragma once
#include "elementary.h"
#include "mind.h"

namespace slcs2 {

// log10(|rho| + 1) sgn(rho); 0 for agents that did not act.
inline Floats gain(Floats reward, Mask acts) {
  const Floats size = logarithm(magnitude(reward) + 1.0f) * 0.43429448f;
  return where(acts, with_sign_of(size, reward));
}

// Credit of the set of so many steps ago: the sum over t' <= BP_max of lambda^t' times the gain of t' steps after it.
// `gains(k)`: that of k steps ago.
template <class T, class Gains>
inline T credit(int age, int depth, const T* weights, T zero, Gains gains) {
  T sum = zero;
  for (int later = 0; later <= std::min(age, depth); later++) sum += weights[later] * gains(age - later);
  return sum;
}

// lambda^t' for t' = 0, 1, ..., by squaring, as XLA does it.
template <class T>
struct Weights {
  T of[HISTORY];

  Weights(T decay, T one) {
    for (int k = 0; k < HISTORY; k++) {
      T power = one, square = decay;
      for (int left = k; left; left >>= 1, square *= square)
        if (left & 1) power *= square;
      of[k] = power;
    }
  }
};

// At the end: credit the sets that are not BP_max steps old, and divide by usage; 0 for rules never used. They are
// credited in the order in which further rounds of an episode that stands still would do it, so that it does not matter
// how many there were. `step`: the last one; `recent`: [BP_max], the agent's last gains, the latest first.
inline void finish_strength(Mind& mind, const float* recent, int step, float decay) {
  const int depth = mind.sizes->depth;
  const Weights<float> weights(decay, 1.0f);
  for (int end = depth; end > 0; end -= mind.sizes->round)
    for (int age = std::max(end - mind.sizes->round, 0); age < end; age++) {
      const float amount = credit(age, depth, weights.of, 0.0f, [&](int k) { return recent[k]; });
      for_each(mind.set(step + HISTORY - age), mind.words, [&](int r) { mind.strength[r] += amount; });
    }
  for (int r = 0; r < mind.sizes->rules; r++)
    mind.strength[r] = mind.usage[r] > 0 ? mind.strength[r] / (float)mind.usage[r] : 0.0f;
}

// After a round whose last step was `step`: credit the sets that became BP_max steps old in it. minds: [n, LANES]; awake: the lanes that count.
inline void settle(Group& g, Mind* minds, const bool* awake, int step) {
  const int depth = g.sizes.depth, length = g.sizes.round;
  const Weights<Floats> weights(g.parameters.trace_decay, all(1.0f));
  for (int i = 0; i < g.n; i++) {
    Floats* recent = g.recent + (size_t)i * depth;
    const Floats* gains = g.gains + (size_t)i * length;
    const auto ago = [&](int k) { return k < length ? gains[length - 1 - k] : recent[k - length]; };
    Floats due[HISTORY];
    for (int k = 0; k < length; k++) due[k] = credit(depth + k, depth, weights.of, all(0.0f), ago);
    for (int lane = 0; lane < LANES; lane++) {
      if (!awake[lane]) continue;
      Mind& mind = minds[i * LANES + lane];
      for (int k = 0; k < length; k++) {
        const float amount = due[k][lane];
        for_each(mind.set(step + HISTORY - depth - k), mind.words, [&](int r) { mind.strength[r] += amount; });
      }
    }
    Floats latest[HISTORY];
    for (int k = 0; k < depth; k++) latest[k] = ago(k);
    memcpy(recent, latest, depth * sizeof *latest);
  }
}

}  // namespace slcs2
