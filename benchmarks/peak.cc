// The most that a core makes of a vector type's additions and multiplications: many that do not wait for each other.
#include <ctime>

#include "vector.h"

using namespace slcs2;

// Operations on single numbers per second of processor time.
extern "C" double peak(long rounds) {
  constexpr int CHAINS = 12;  // as many as registers hold, and more than any latency
  Floats value[CHAINS], factor = all(0.999f), term = all(0.001f);
  asm volatile("" : "+m"(factor), "+m"(term));
  for (int k = 0; k < CHAINS; k++) value[k] = all((float)k);
  const std::clock_t start = std::clock();
  for (long r = 0; r < rounds; r++)
    for (int k = 0; k < CHAINS; k++) value[k] = value[k] * factor + term;
  const double seconds = (double)(std::clock() - start) / CLOCKS_PER_SEC;
  Floats sum = all(0.0f);
  for (int k = 0; k < CHAINS; k++) sum += value[k];
  asm volatile("" : : "m"(sum));
  return 2.0 * LANES * CHAINS * (double)rounds / seconds;
}
