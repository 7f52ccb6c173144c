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

// Whether a mask holds in any lane: halves are joined until one machine word is left.
template <int Count>
inline bool any_of(const int32_t* values) {
  if constexpr (Count == 1) {
    return values[0] != 0;
  } else if constexpr (Count == 2) {
    uint64_t both;
    memcpy(&both, values, sizeof both);
    return both != 0;
  } else {
    typedef int32_t Half __attribute__((vector_size(2 * Count)));
    Half low, high;
    memcpy(&low, values, sizeof low);
    memcpy(&high, values + Count / 2, sizeof high);
    low |= high;
    int32_t joined[Count / 2];
    memcpy(joined, &low, sizeof low);
    return any_of<Count / 2>(joined);
  }
}
inline bool any(Mask m) {
  int32_t values[LANES];
  memcpy(values, &m, sizeof m);
  return any_of<LANES>(values);
}

}  // namespace slcs2
