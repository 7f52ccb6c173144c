// The native chunk as a program of its own, for processors that are emulated: reads sizes and arrays of a call from the
// standard input, writes what the call made of those that it changes.
#include <cstdio>
#include <vector>

#include "chunk.cc"

using namespace slcs2;

static std::vector<char> take(size_t bytes) {
  std::vector<char> array(bytes + 64);  // room for a pointer even where there is nothing
  if (fread(array.data(), 1, bytes, stdin) != bytes) exit(1);
  return array;
}

int main() {
  Sizes sizes;
  memcpy(&sizes, take(sizeof sizes).data(), sizeof sizes);
  Buffers buffers{};
  std::vector<std::vector<char>> arrays;
  for (int k = 0; k < GIVEN; k++)
    arrays.push_back(take(given_bytes(sizes, k))), buffers.given[k] = arrays.back().data();
  const int kept = kept_buffers(sizes);
  for (int k = 0; k < kept; k++)
    arrays.push_back(take(kept_bytes(sizes, k))), buffers.kept[k] = arrays.back().data();
  slcs2_advance(&sizes, &buffers, 1);
  for (int k = 0; k < kept; k++) fwrite(buffers.kept[k], 1, kept_bytes(sizes, k), stdout);
  return 0;
}
