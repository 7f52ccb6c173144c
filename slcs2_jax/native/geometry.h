// Axis-aligned walls: which links cross them, how near they are. See world/geometry.py.
//
// A wall is a centre line with a thickness. Vertical ones stand at x = `at` and span y in [low, high]; horizontal ones
// are the same with x and y exchanged, so every function is written once, for vertical walls. Each episode has walls of
// its own, sorted by `at`: a link can only cross those that stand between its ends.
#pragma once
#include <algorithm>
#include <cmath>

#include "state.h"

namespace slcs2 {

// Parallel walls of one episode.
struct Lines {
  int count;
  float *at, *low, *high;  // [count, and room for one vector more]
  int* number;             // the place that each had before they were sorted: the first of equals is the nearest

  static Lines take(Store& store, int capacity) {
    const size_t room = (size_t)capacity + LANES;
    return {0, store.take<float>(room), store.take<float>(room), store.take<float>(room), store.take<int>(room)};
  }

  // From columns of padded tables [capacity, batch]; low > high is padding.
  void fill(const float* at_, const float* low_, const float* high_, int capacity, int batch, int episode) {
    count = 0;
    for (int k = 0; k < capacity; k++) {
      const size_t from = (size_t)k * batch + episode;
      if (low_[from] <= high_[from]) number[count++] = k;
    }
    std::stable_sort(number, number + count, [&](int a, int b) {
      return at_[(size_t)a * batch + episode] < at_[(size_t)b * batch + episode];
    });
    for (int k = 0; k < count; k++) {
      const size_t from = (size_t)number[k] * batch + episode;
      at[k] = at_[from], low[k] = low_[from], high[k] = high_[from];
    }
    for (int k = count; k < count + LANES; k++) at[k] = INFINITE, low[k] = INFINITE, high[k] = -INFINITE;
  }

  // How many stand at x or before it; looked for from a place that may be near.
  int rank(float x, int from) const {
    while (from < count && at[from] <= x) from++;
    while (from > 0 && at[from - 1] > x) from--;
    return from;
  }

  // How many of those in [from, to) the line through (x1, y1) with a slope crosses.
  int crossed(float x1, float y1, float slope, int from, int to) const {
    Ints count{};
    Ints place;
    for (int lane = 0; lane < LANES; lane++) place[lane] = lane;
    for (int k = from; k < to; k += LANES) {
      Floats at8, low8, high8;
      memcpy(&at8, at + k, sizeof at8), memcpy(&low8, low + k, sizeof low8), memcpy(&high8, high + k, sizeof high8);
      const Floats height = y1 + (at8 - x1) * slope;
      count -= (height >= low8) & (height <= high8) & (place < to - k);
    }
    int sum = 0;
    for (int lane = 0; lane < LANES; lane++) sum += count[lane];
    return sum;
  }
};

inline float slope(float x1, float y1, float x2, float y2) { return x2 == x1 ? 0.0f : (y2 - y1) / (x2 - x1); }

// Walls of the episodes of a lane group.
struct Walls {
  Lines vertical[LANES], horizontal[LANES];
};

// How many walls each link crosses. Kept from step to step: only the links of who moved are counted again.
class Crossings {
 public:
  Crossings(int nodes, int bodies, Store& store) : nodes_(nodes), bodies_(bodies) {
    count_ = store.take<Floats>((size_t)nodes * bodies);
    for (float** table : {&x_, &y_}) *table = store.take<float>((size_t)bodies * LANES);
    for (int** table : {&east_, &north_}) *table = store.take<int>((size_t)bodies * LANES);
  }

  // Of the link of node i and body j > i.
  Floats counted(int i, int j) const { return count_[(size_t)i * bodies_ + j]; }

  // Forget everything: all will be counted anew.
  void reset() {
    for (int k = 0; k < nodes_ * bodies_; k++) count_[k] = all(0.0f);
    for (int k = 0; k < bodies_ * LANES; k++) x_[k] = y_[k] = __builtin_nanf(""), east_[k] = north_[k] = 0;
  }

  void update(const Group& g, const Walls& walls) {
    bool moved[MOST_BODIES];
    for (int lane = 0; lane < LANES; lane++) {
      float *x = x_ + lane * bodies_, *y = y_ + lane * bodies_;
      int *east = east_ + lane * bodies_, *north = north_ + lane * bodies_;
      const Lines &vertical = walls.vertical[lane], &horizontal = walls.horizontal[lane];
      if (vertical.count + horizontal.count == 0) continue;
      for (int i = 0; i < bodies_; i++) {
        const float new_x = g.x[i][lane], new_y = g.y[i][lane];
        moved[i] = new_x != x[i] || new_y != y[i];
        if (!moved[i]) continue;
        x[i] = new_x, y[i] = new_y;
        east[i] = vertical.rank(new_x, east[i]), north[i] = horizontal.rank(new_y, north[i]);
      }
      for (int i = 0; i < nodes_; i++)
        for (int j = i + 1; j < bodies_; j++) {
          if (!(moved[i] || moved[j])) continue;
          int count = 0;
          if (east[i] != east[j]) {
            const auto [from, to] = std::minmax(east[i], east[j]);
            count += vertical.crossed(x[i], y[i], slope(x[i], y[i], x[j], y[j]), from, to);
          }
          if (north[i] != north[j]) {
            const auto [from, to] = std::minmax(north[i], north[j]);
            count += horizontal.crossed(y[i], x[i], slope(y[i], x[i], y[j], x[j]), from, to);
          }
          count_[(size_t)i * bodies_ + j][lane] = (float)count;
        }
    }
  }

 private:
  const int nodes_, bodies_;
  Floats* count_;        // [nodes, bodies], where the first is the lower one
  float *x_, *y_;        // [lane, bodies], where everybody was when last counted
  int *east_, *north_;   // [lane, bodies], walls passed on the way there along each axis
};

// The nearest point of something in each episode: squared distance, m2, infinite if there is none, and the point, m.
struct Nearest {
  Floats squared = all(INFINITE), x = all(0.0f), y = all(0.0f);

  void take_nearer(Floats candidate, Floats at_x, Floats at_y) {
    const Mask nearer = candidate < squared;
    squared = nearer ? candidate : squared, x = nearer ? at_x : x, y = nearer ? at_y : y;
  }
};

// Squared distance of a place to a vertical wall's surface, m2.
inline float wall_distance(float x, float y, float half, float at, float low, float high) {
  const float across = std::max(std::fabs(x - at) - half, 0.0f);
  const float along = std::max(std::max(low - y, y - high), 0.0f);
  return across * across + along * along;
}

struct Step {
  float x, y, to_x, to_y;
};

struct NearestPoint {
  float squared = INFINITE, x = 0.0f, y = 0.0f;
};

// The nearest surface point of those vertical walls within reach that count, the first of equals.
template <class Counts>
inline NearestPoint nearest_line(const Lines& lines, const Step& step, float reach, float half, Counts counts) {
  const float low_x = std::min(step.x, step.to_x), high_x = std::max(step.x, step.to_x);
  reach += half + SLACK + 1e-6f * std::max(std::fabs(low_x), std::fabs(high_x));  // and what rounding may take away
  NearestPoint best;
  int first = 0;
  int k = (int)(std::lower_bound(lines.at, lines.at + lines.count, low_x - reach) - lines.at);
  for (; k < lines.count && lines.at[k] <= high_x + reach; k++) {
    const float at = lines.at[k], low = lines.low[k], high = lines.high[k];
    const float squared = wall_distance(step.x, step.y, half, at, low, high);
    if (squared > best.squared || (squared == best.squared && lines.number[k] > first)) continue;
    if (!counts(squared, at, low, high)) continue;
    best.squared = squared, first = lines.number[k];
    best.x = std::min(std::max(step.x, at - half), at + half), best.y = std::min(std::max(step.y, low), high);
  }
  return best;
}

// Put the nearest of vertical and horizontal walls of each episode that asks into `best`, vertical walls first on ties.
template <class Side>
inline Nearest nearest_of_both(const Walls& walls, Mask asks, Floats x, Floats y, Floats to_x, Floats to_y, Side side) {
  Nearest best;
  for (int lane = 0; lane < LANES; lane++) {
    if (!asks[lane]) continue;
    NearestPoint found = side(lane, walls.vertical[lane], Step{x[lane], y[lane], to_x[lane], to_y[lane]});
    const NearestPoint other = side(lane, walls.horizontal[lane], Step{y[lane], x[lane], to_y[lane], to_x[lane]});
    if (other.squared < found.squared) found = {other.squared, other.y, other.x};
    best.squared[lane] = found.squared, best.x[lane] = found.x, best.y[lane] = found.y;
  }
  return best;
}

// The nearest point of any wall's surface that is within reach, m.
inline Nearest nearest_wall(const Walls& walls, Mask asks, Floats x, Floats y, Floats reach, const Parameters& p) {
  return nearest_of_both(walls, asks, x, y, x, y, [&](int lane, const Lines& lines, const Step& step) {
    return nearest_line(lines, step, reach[lane], p.half_thickness[lane], [](float, float, float, float) { return true; });
  });
}

// The nearest point, seen from (x, y), of the walls that forbid a step to (to_x, to_y): it ends nearer to the wall's
// surface than the clearance and than it began, or it crosses the wall's centre line.
inline Nearest blocking_wall(const Walls& walls, Mask asks, Floats x, Floats y, Floats to_x, Floats to_y,
                             const Parameters& p) {
  return nearest_of_both(walls, asks, x, y, to_x, to_y, [&](int lane, const Lines& lines, const Step& step) {
    const float rise = slope(step.x, step.y, step.to_x, step.to_y);
    const float half = p.half_thickness[lane], clear = p.clear[lane];
    const auto forbids = [&](float before, float at, float low, float high) {
      const float after = wall_distance(step.to_x, step.to_y, half, at, low, high);
      const float height = step.y + (at - step.x) * rise;
      const bool crosses = (step.x < at) != (step.to_x < at) && height >= low && height <= high;
      return after < std::min(clear, before) || crosses;
    };
    return nearest_line(lines, step, root(clear), half, forbids);
  });
}

}  // namespace slcs2
