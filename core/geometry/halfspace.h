// All that lies below a plane. Unbounded, so it is an operand of CSG alone, where the result's bounds cut it off: a
// line then crosses it evenly, as everything else. Faces: 0 the plane; 1 to 6 those of the cut, outside the result.
#pragma once

#include "base/box.h"
#include "base/check.h"
#include "base/frame.h"
#include "base/twofold.h"
#include "geometry/block.h"

namespace tilecast {

struct Halfspace {
  static constexpr int kFaces = 7;
  Vec3 normal{0.0, 1.0, 0.0};  // of unit length once `of` has made it
  double offset = 0.0;         // metres, from the origin along the normal; inside is where dot(normal, p) is less
  Vec3 lo{-kInfinity}, hi{kInfinity};

  // normal: of any length.
  static Halfspace of(const Vec3& normal, double offset) {
    if (!(max_abs(normal) > 0.0)) throw Error("normal: must not be [0, 0, 0]");
    if (!(is_finite(normal) && max_abs(normal) >= kShortest && max_abs(normal) <= kLongest))
      throw Error("normal: its largest component must lie between 1e-100 and 1e100");
    Vec3 scaled = normal * power_below_reciprocal(max_abs(normal));
    return {scaled / std::sqrt(glm::dot(scaled, scaled)), offset};
  }
};

inline void check(const Halfspace& h) {
  if (!(std::fabs(h.offset) <= kLongest))
    throw Error("offset: must lie between -1e100 and 1e100, got " + text(h.offset));
}
inline Box bounds(const Halfspace& h) { return {h.lo, h.hi}; }

inline Interval inside(const Halfspace& h, const Ray& line) {
  Interval interval = inside_block(h.lo, h.hi, line, 1);
  Twofold along = twofold_dot(h.normal, line.direction), beyond = twofold_dot(h.normal, line.origin) - h.offset;
  double d = along.value();
  if (d == 0.0) {
    interval.empty = interval.empty || !(beyond.value() < 0.0);
    return interval;
  }
  Interval below;
  double moved = 4 * kUnitRoundoff * (glm::dot(glm::abs(h.normal), glm::abs(line.origin)) + std::fabs(h.offset));
  SolidCrossing plane{-beyond.value() / d, moved / std::fabs(d), 0, d < 0.0};
  (d < 0.0 ? below.enter : below.exit) = plane;
  interval.intersect(below);
  return interval;
}

inline Vec3 outward(const Halfspace& h, int face, const Vec3&) {
  return face == 0 ? h.normal : block_outward(face - 1);
}
inline Vec3 project(const Halfspace& h, int face, const Vec3& p) {
  if (face != 0) return block_project(h.lo, h.hi, face - 1, p);
  return p - (twofold_dot(h.normal, p) - h.offset).value() * h.normal;
}

}  // namespace tilecast
