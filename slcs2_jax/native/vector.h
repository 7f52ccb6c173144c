// Lanes: one episode each. Vectors of the compiler's own (GCC, Clang), so that SSE, AVX2, AVX-512 and NEON come from one
// source. Every operation here is exact or rounded as IEEE 754 says, so no width and no machine changes a bit.
#pragma once
#include <cstdint>
#include <cstring>

#ifndef SLCS2_LANES
#define SLCS2_LANES 8
#endif

namespace slcs2 {

constexpr int LANES = SLCS2_LANES;

typedef float Floats __attribute__((vector_size(4 * LANES)));
typedef int32_t Ints __attribute__((vector_size(4 * LANES)));
typedef uint32_t Words __attribute__((vector_size(4 * LANES)));
typedef Ints Mask;  // -1 where it holds, 0 elsewhere

constexpr float INFINITE = __builtin_inff();

inline Floats all(float value) { return value - Floats{}; }
inline Ints all(int32_t value) { return value - Ints{}; }
inline Words all(uint32_t value) { return value - Words{}; }
inline Mask mask(bool value) { return all(value ? -1 : 0); }

inline Floats maximum(Floats a, Floats b) { return a > b ? a : b; }
inline Floats minimum(Floats a, Floats b) { return a < b ? a : b; }
inline Ints bits(Floats a) { return (Ints)a; }
inline Floats where(Mask m, Floats a) { return (Floats)(m & (Ints)a); }  // a, or 0
inline Floats magnitude(Floats a) { return (Floats)((Ints)a & 0x7FFFFFFF); }
inline Floats with_sign_of(Floats size, Floats sign) { return (Floats)((Ints)size | ((Ints)sign & INT32_MIN)); }
inline Floats squared(Floats a) { return a * a; }
inline Floats squared_distance(Floats x1, Floats y1, Floats x2, Floats y2) {
  return squared(x2 - x1) + squared(y2 - y1);
}

inline Floats root(Floats a) {
  Floats r;
  for (int lane = 0; lane < LANES; lane++) r[lane] = __builtin_sqrtf(a[lane]);
  return r;
}

inline float root(float a) { return __builtin_sqrtf(a); }

inline Ints numbered() {
  Ints numbers;
  for (int lane = 0; lane < LANES; lane++) numbers[lane] = lane;
  return numbers;
}

// All elements joined by `or`, halves at a time.
template <int Count>
inline uint32_t joined(const uint32_t* values) {
  if constexpr (Count == 1) {
    return values[0];
  } else if constexpr (Count == 2) {
    return values[0] | values[1];
  } else {
    typedef uint32_t Half __attribute__((vector_size(2 * Count)));
    Half low, high;
    memcpy(&low, values, sizeof low);
    memcpy(&high, values + Count / 2, sizeof high);
    low |= high;
    uint32_t half[Count / 2];
    memcpy(half, &low, sizeof low);
    return joined<Count / 2>(half);
  }
}
inline uint32_t joined(Words vector) {
  uint32_t values[LANES];
  memcpy(values, &vector, sizeof vector);
  return joined<LANES>(values);
}

// Whether a mask holds in any lane, and in which: a bit for each.
inline bool any(Mask m) { return joined((Words)m) != 0; }
inline uint32_t lanes_of(Mask m) { return joined((Words)m & (1u << (Words)numbered())); }

// The greatest element; of zeros of both signs any.
template <class V>
inline auto greatest(V vector) {
  auto most = vector[0];
  if constexpr (LANES > 1) {
    typedef decltype(most) E;
    typedef E Half __attribute__((vector_size(2 * LANES)));
    Half low, high;
    memcpy(&low, &vector, sizeof low);
    memcpy(&high, (const char*)&vector + sizeof low, sizeof high);
    low = low > high ? low : high;
    for (int lane = 0; lane < LANES / 2; lane++) most = low[lane] > most ? low[lane] : most;
  }
  return most;
}

template <class V, class E>
inline V load(const E* from) {
  V vector;
  memcpy(&vector, from, sizeof vector);
  return vector;
}

}  // namespace slcs2
