// Where a line is inside: intervals of its parameter, with what is crossed at their ends.
//
// A convex solid is an intersection of intervals, or the hull of those of its parts, so a line never crosses it an odd
// number of times, however it meets a rim or an apex.
#pragma once

#include "base/ray.h"

namespace tilecast {

struct SolidCrossing {
  double t;
  double error;  // bound on the error of t, for a line whose coordinates are themselves rounded
  int face;
  bool entering;
};
inline constexpr int kMaxSolidCrossings = 4;

struct Interval {
  SolidCrossing enter{-kInfinity, 0.0, 0, true}, exit{kInfinity, 0.0, 0, false};
  bool empty = false;

  static Interval nothing() {
    Interval interval;
    interval.empty = true;
    return interval;
  }

  void intersect(const Interval& other) {
    empty = empty || other.empty;
    if (other.enter.t > enter.t) enter = other.enter;
    if (other.exit.t < exit.t) exit = other.exit;
    if (!(enter.t < exit.t)) empty = true;
  }

  // With a part of the same convex whole.
  void extend(const Interval& part) {
    if (part.empty) return;
    if (empty || part.enter.t < enter.t) enter = part.enter;
    if (empty || part.exit.t > exit.t) exit = part.exit;
    empty = false;
  }
};

// Of a solid that is not convex: sorted; they may touch.
struct Intervals {
  Interval item[kMaxSolidCrossings / 2];
  int count = 0;

  void add(const Interval& interval) {
    if (!interval.empty) item[count++] = interval;
  }
};

// Both return how many crossings they wrote: sorted, entries and exits in turn, each strictly after the one before.
inline int write(const Interval& interval, SolidCrossing* out) {
  if (interval.empty || !std::isfinite(interval.enter.t) || !std::isfinite(interval.exit.t)) return 0;
  out[0] = interval.enter;
  out[1] = interval.exit;
  return 2;
}

inline int write(const Intervals& intervals, SolidCrossing* out) {
  int count = 0;
  for (int i = 0; i < intervals.count; ++i) {
    int more = write(intervals.item[i], out + count);
    if (more > 0 && count > 0 && !(out[count - 1].t < out[count].t)) {  // they touch: no gap between
      out[count - 1] = out[count + 1];
    } else {
      count += more;
    }
  }
  return count;
}

inline Interval inside_slab(double o, double d, double lo, double hi, int low_face, int high_face) {
  Interval interval;
  if (d == 0.0) {
    interval.empty = !(lo <= o && o < hi);  // half open: of two slabs side by side a line is in one
    return interval;
  }
  double low = (lo - o) / d, high = (hi - o) / d;
  double scale = 4 * kUnitRoundoff / std::fabs(d);
  SolidCrossing at_low{low, scale * (std::fabs(o) + std::fabs(lo)), low_face, d > 0.0};
  SolidCrossing at_high{high, scale * (std::fabs(o) + std::fabs(hi)), high_face, d < 0.0};
  interval.enter = d > 0.0 ? at_low : at_high;
  interval.exit = d > 0.0 ? at_high : at_low;
  if (!(interval.enter.t < interval.exit.t)) interval.empty = true;
  return interval;
}

}  // namespace tilecast
