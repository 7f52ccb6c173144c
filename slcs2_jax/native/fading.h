// How received power varies around its mean. See world/fading.py: each model gives log2 of a link's gain in power, from
// uniform words; `word(k)` is the k-th of every link.
#pragma once
#include "elementary.h"
#include "randomness.h"
#include "state.h"

namespace slcs2 {

struct NoFading {
  template <class Draw>
  Floats gain(Draw) const { return all(0.0f); }
};

// X ~ N(0, sigma^2) in dB, the paper's.
struct LogNormal {
  Floats sigma;

  template <class Draw>
  Floats gain(Draw word) const { return sigma * normal(word(0)); }
};

// Power times Exp(1) (Simon and Alouini 2005, section 2.2.1.1), by the inverse distribution function.
struct Rayleigh {
  template <class Draw>
  Floats gain(Draw word) const { return logarithm2(-logarithm(uniform(word(0)))); }
};

// |h|^2 = ((X + sqrt(2K))^2 + Y^2) / (2 (K + 1)) with X, Y ~ N(0, 1) (Simon and Alouini 2005, section 2.2.1.3).
struct Rician {
  Floats direct, mean;

  explicit Rician(Floats k) : direct(root(2.0f * k)), mean(2.0f * (k + 1.0f)) {}

  template <class Draw>
  Floats gain(Draw word) const {
    const Floats x = normal(word(0)) + direct, y = normal(word(1));
    return logarithm2(maximum((x * x + y * y) / mean, all(1e-12f)));
  }
};

// Gamma(m, 1/m) (Simon and Alouini 2005, section 2.2.1.4) by Marsaglia and Tsang, ACM TOMS 26 (2000): of so many tries
// the first that the method accepts, else its mean; for m < 1 a deviate of m + 1 times U^(1/m).
struct Nakagami {
  static constexpr int TRIES = 4;
  Floats m, shape, d, c;

  explicit Nakagami(Floats m_)
      : m(m_), shape(m < 1.0f ? m + 1.0f : m), d(shape - 1.0f / 3.0f), c(1.0f / root(9.0f * d)) {}

  template <class Draw>
  Floats gain(Draw word) const {
    Floats drawn = shape;
    Mask pending = mask(true);
    for (int trial = 0; trial < TRIES && any(pending); trial++) {
      const Floats x = normal(word(2 * trial)), u = uniform(word(2 * trial + 1)), side = 1.0f + c * x;
      const Mask inside = side > 0;
      const Floats cubed = inside ? side : all(1.0f), v = cubed * (cubed * cubed);
      const Mask accepted = inside & (logarithm(u) < 0.5f * x * x + d * (1.0f - v + logarithm(v)));
      drawn = pending & accepted ? d * v : drawn;
      pending &= ~accepted;
    }
    const Floats gain = logarithm2(drawn / m);
    const Mask boosted = m < 1.0f;
    return any(boosted) ? (boosted ? gain + logarithm2(uniform(word(2 * TRIES))) / m : gain) : gain;
  }
};

// Call `work` with the fading of the episodes.
template <class Work>
inline void with_fading(const Group& g, Work work) {
  const Floats parameter = g.parameters.fading;
  switch (g.sizes.fading) {
    case NO_FADING: return work(NoFading{});
    case LOG_NORMAL: return work(LogNormal{parameter});
    case RAYLEIGH: return work(Rayleigh{});
    case RICIAN: return work(Rician(parameter));
    default: return work(Nakagami(parameter));
  }
}

}  // namespace slcs2
