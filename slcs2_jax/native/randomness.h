// Random numbers of an episode: a draw depends on its name alone. See world/randomness.py, which says the same in JAX.
#pragma once
#include "elementary.h"
#include "vector.h"

namespace slcs2 {

constexpr uint32_t GOLDEN = 0x9E3779B9u;

enum Purpose : uint32_t {
  SHADOWING = 0, RULE = 1, COLLECT = 2, FADING = 3, JAMMER_LINK = 4, EMISSION = 5, FAILURE = 6, RECOVERY = 7,
  FAILURE_LOT = 8
};

// lowbias32 (C. Wellons), in two rounds; for one word or a vector of them.
template <class T>
inline T first_round(T x) {
  x = x ^ (x >> 16);
  x = x * 0x7FEB352Du;
  return x ^ (x >> 15);
}

template <class T>
inline T second_round(T x) {
  x = x * 0x846CA68Bu;
  return x ^ (x >> 16);
}

template <class T>
inline T mix(T x) {
  return second_round(first_round(x));
}

template <class T>
struct Stream {
  T low, high;

  T draw(uint32_t index) const { return second_round(first_round(low ^ (index * GOLDEN)) + high); }
};

inline Stream<Words> stream(Words key_low, Words key_high, Ints t, Purpose purpose) {
  const Words step = mix(key_low + (Words)t) ^ key_high;
  const Words low = mix(step + (uint32_t)purpose * GOLDEN);
  return {low, mix(low + key_low)};
}

inline Stream<uint32_t> in_lane(const Stream<Words>& all, int lane) { return {all.low[lane], all.high[lane]}; }

// Uniform numbers from 2^-24 to 1 - 2^-24.
inline Floats uniform(Words word) {
  return __builtin_convertvector((Ints)(word >> 9), Floats) * (1.0f / (1 << 23)) + 1.0f / (1 << 24);
}

// Standard normal deviates by the inverse distribution function (M. Giles 2010, "Approximating the erfinv function").
inline Floats normal(Words word) {
  constexpr float CENTRE[] = {2.81022636e-08f,   3.43273939e-07f,   -3.5233877e-06f, -4.39150654e-06f, 0.00021858087f,
                              -0.00125372503f,   -0.00417768164f,   0.246640727f,    1.50140941f};
  constexpr float TAIL[] = {-0.000200214257f, 0.000100950558f, 0.00134934322f, -0.00367342844f, 0.00573950773f,
                            -0.0076224613f,   0.00943887047f,  1.00167406f,    2.83297682f};
  constexpr float HALF = 1.0f / (1 << 24);
  const Floats x = __builtin_convertvector((Ints)(word >> 8), Floats) * (2 * HALF) + (HALF - 1.0f);
  const Floats w = -logarithm((1.0f - x) * (1.0f + x));
  Floats p = polynomial(CENTRE, w - 2.5f);
  const Mask tail = w >= 5.0f;
  if (any(tail)) p = tail ? polynomial(TAIL, root(maximum(w, all(0.0f))) - 3.0f) : p;
  return (1.41421356f * x) * p;
}

}  // namespace slcs2
