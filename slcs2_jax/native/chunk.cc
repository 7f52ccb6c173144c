// The two calls that Python makes: a chunk of steps, and the figures of episodes that are over. Each is an XLA custom call
// and a plain C function of the same name in small letters, which takes arrays of the host and shares the work out to
// threads.
#include <atomic>
#include <cfenv>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "episode.h"
#ifndef SLCS2_WITHOUT_XLA
#include "xla/ffi/api/ffi.h"
#endif

namespace slcs2 {
namespace {

// Numbers as IEEE 754 has them, whatever the calling thread likes: denormal ones too, rounded to the nearest.
class Rounding {
 public:
  Rounding() { std::fegetenv(&callers_), std::fesetenv(FE_DFL_ENV); }
  ~Rounding() { std::fesetenv(&callers_); }

 private:
  std::fenv_t callers_;
};

// Let `work` compute every lane group, whichever thread is free the next one. Groups share no memory that is written, so
// who computes a group, and beside which, decides nothing.
template <class Work>
void each_group(const Sizes& sizes, const Buffers& buffers, int threads, Work work) {
  std::atomic<int> next{0};
  std::atomic<bool> out_of_memory{false};
  const auto some = [&] {
    try {
      const Rounding rounding;
      Store counting;
      Simulation(sizes, counting);
      Store store(counting.used());
      Simulation simulation(sizes, store);
      for (int begin = LANES * next++; begin < sizes.batch; begin = LANES * next++) work(simulation, begin);
    } catch (const std::bad_alloc&) {
      out_of_memory = true;
    }
  };
  std::vector<std::thread> others;
  const int groups = (sizes.batch + LANES - 1) / LANES, most = std::min(threads, groups);
  others.reserve(std::max(most, 0));
  try {
    while ((int)others.size() < most - 1) others.emplace_back(some);
  } catch (const std::system_error&) {
    // the system gives no more threads: those that there are do all of it
  }
  some();
  for (std::thread& other : others) other.join();
  if (out_of_memory) throw std::bad_alloc();
}

// Whether no episode of a lane group has time left: there is nothing to load.
bool is_idle(const Sizes& sizes, const Buffers& buffers, int begin) {
  const int32_t *t = (const int32_t*)buffers.kept[T], *limit = (const int32_t*)buffers.given[TIME_LIMIT];
  for (int k = begin; k < std::min(begin + LANES, sizes.batch); k++)
    if (t[k] < limit[k]) return false;
  return !(sizes.noted && begin == 0);  // the notes are written in any case
}

void advance(const Sizes& sizes, const Buffers& buffers, int threads) {
  each_group(sizes, buffers, threads, [&](Simulation& simulation, int begin) {
    if (!is_idle(sizes, buffers, begin)) simulation.advance(buffers, begin);
  });
}

void finish(const Sizes& sizes, const Buffers& buffers, int threads) {
  each_group(sizes, buffers, threads, [&](Simulation& simulation, int begin) { simulation.finish(buffers, begin); });
}

// 0, or 1 if there was no memory.
template <void (*work)(const Sizes&, const Buffers&, int)>
int plainly(const Sizes* sizes, const Buffers* buffers, int threads) {
  try {
    work(*sizes, *buffers, threads);
    return 0;
  } catch (const std::bad_alloc&) {
    return 1;
  }
}

}  // namespace
}  // namespace slcs2

extern "C" int slcs2_advance(const slcs2::Sizes* sizes, const slcs2::Buffers* buffers, int threads) {
  return slcs2::plainly<slcs2::advance>(sizes, buffers, threads);
}

extern "C" int slcs2_finish(const slcs2::Sizes* sizes, const slcs2::Buffers* buffers, int threads) {
  return slcs2::plainly<slcs2::finish>(sizes, buffers, threads);
}

// How many episodes are computed side by side: the batch is cut into groups of so many.
extern "C" int slcs2_lanes() { return slcs2::LANES; }

// What this library was compiled from.
extern "C" const char* slcs2_key() {
#ifdef SLCS2_KEY
  return SLCS2_KEY;
#else
  return "";
#endif
}

#ifndef SLCS2_WITHOUT_XLA
namespace slcs2 {
namespace {

namespace ffi = xla::ffi;

// The arrays of an XLA call, each of the size that it must have. Results begin as copies of the state that they replace,
// which XLA lets them share the memory with where it can.
ffi::Error gather(ffi::RemainingArgs& arguments, ffi::RemainingRets& results, const Sizes& sizes, Buffers& buffers) {
  const size_t kept = kept_buffers(sizes), noted = sizes.noted ? NOTED : 0;
  if (arguments.size() != GIVEN + kept || results.size() != kept + noted)
    return ffi::Error::InvalidArgument("slcs2: wrong number of arrays");
  const auto wrong = [](size_t which) {
    return ffi::Error::InvalidArgument("slcs2: array " + std::to_string(which) + " has the wrong size");
  };
  for (size_t k = 0; k < GIVEN + kept; k++) {
    const auto array = arguments.get<ffi::AnyBuffer>(k);
    const size_t bytes = k < GIVEN ? given_bytes(sizes, k) : kept_bytes(sizes, k - GIVEN);
    if (!array.has_value() || array->size_bytes() != bytes) return wrong(k);
    if (k < GIVEN) buffers.given[k] = array->untyped_data();
  }
  for (size_t k = 0; k < kept + noted; k++) {
    auto array = results.get<ffi::AnyBuffer>(k);
    const size_t bytes = k < kept ? kept_bytes(sizes, k) : noted_bytes(sizes, k - kept);
    if (!array.has_value() || (*array)->size_bytes() != bytes) return wrong(GIVEN + kept + k);
    void* data = (*array)->untyped_data();
    if (k >= kept) {
      buffers.noted[k - kept] = data;
      continue;
    }
    const void* before = arguments.get<ffi::AnyBuffer>(GIVEN + k)->untyped_data();
    if (data != before) memcpy(data, before, bytes);
    buffers.kept[k] = data;
  }
  return ffi::Error::Success();
}

// On the thread that XLA calls it on.
template <void (*work)(const Sizes&, const Buffers&, int)>
ffi::Error call(ffi::RemainingArgs arguments, ffi::RemainingRets results, ffi::Span<const int32_t> numbers) {
  Sizes sizes;
  if (numbers.size() * sizeof(int32_t) != sizeof sizes) return ffi::Error::InvalidArgument("slcs2: wrong sizes");
  memcpy(&sizes, numbers.begin(), sizeof sizes);
  Buffers buffers{};
  if (const ffi::Error error = gather(arguments, results, sizes, buffers); error.failure()) return error;
  try {
    work(sizes, buffers, 1);
  } catch (const std::bad_alloc&) {
    return ffi::Error(ffi::ErrorCode::kResourceExhausted, "slcs2: no memory left");
  }
  return ffi::Error::Success();
}

}  // namespace
}  // namespace slcs2

XLA_FFI_DEFINE_HANDLER_SYMBOL(
    Slcs2Advance, slcs2::call<slcs2::advance>,
    xla::ffi::Ffi::Bind().RemainingArgs().RemainingRets().Attr<xla::ffi::Span<const int32_t>>("sizes"));
XLA_FFI_DEFINE_HANDLER_SYMBOL(
    Slcs2Finish, slcs2::call<slcs2::finish>,
    xla::ffi::Ffi::Bind().RemainingArgs().RemainingRets().Attr<xla::ffi::Span<const int32_t>>("sizes"));
#endif
