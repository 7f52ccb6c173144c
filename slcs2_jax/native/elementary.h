// Logarithm and power of two as polynomials of our own: the C library's differ from machine to machine.
#pragma once
#include "vector.h"

namespace slcs2 {

// Horner's rule, the constant term last.
template <int Count>
inline Floats polynomial(const float (&coefficients)[Count], Floats a) {
  Floats value = all(coefficients[0]);
  for (int k = 1; k < Count; k++) value = value * a + coefficients[k];
  return value;
}

// Natural logarithm of positive normal numbers, error below 1 ulp (S. L. Moshier, Cephes, logf).
inline Floats logarithm(Floats a) {
  const Ints word = bits(a);
  Ints exponent = (Ints)((Words)word >> 23) - 126;
  Floats m = (Floats)((word & 0x7FFFFF) | 0x3F000000);  // in [0.5, 1)
  const Mask small = m < 0.707106781186547524f;
  exponent += small;
  m = (m - 1.0f) + where(small, m);
  const Floats e = __builtin_convertvector(exponent, Floats), z = m * m;
  constexpr float C[] = {7.0376836292e-2f, -1.1514610310e-1f, 1.1676998740e-1f, -1.2420140846e-1f, 1.4249322787e-1f,
                         -1.6668057665e-1f, 2.0000714765e-1f, -2.4999993993e-1f, 3.3333331174e-1f};
  const Floats p = polynomial(C, m);
  return (((p * m) * z + e * -2.12194440e-4f) - 0.5f * z) + m + e * 0.693359375f;
}

inline Floats logarithm2(Floats a) { return logarithm(a) * 1.44269504f; }

// The greatest whole number that is not greater than a, for a >= 0.
inline Floats whole_part(Floats a) {
  const float all_whole = 8388608.0f;  // 2^23: from there on there are no others
  const Ints cut = __builtin_convertvector(minimum(a, all(all_whole)), Ints);
  return a < all_whole ? __builtin_convertvector(cut, Floats) : a;
}

// 2 to the power a, error below 2 ulp; what leaves the range of normal numbers is held at its ends.
inline Floats power_of_two(Floats a) {
  a = minimum(maximum(a, all(-126.0f)), all(127.0f));
  const float rounder = 12582912.0f;  // 1.5 * 2^23: adding it leaves the nearest whole number
  const Floats whole = (a + rounder) - rounder, r = a - whole;
  constexpr float C[] = {1.535336188319500e-4f, 1.339887440266574e-3f, 9.618437357674640e-3f, 5.550332471162809e-2f,
                         2.402264791363012e-1f, 6.931472028550421e-1f, 1.0f};
  const Floats p = polynomial(C, r);
  return p * (Floats)((__builtin_convertvector(whole, Ints) + 127) << 23);
}

}  // namespace slcs2
