// A capsule about y, centred: all that lies within `radius` of a segment of length `height`. One face.
//
// Convex, so a line's interval is the hull of those of its parts: the two balls, and the cylinder between.
#pragma once

#include "base/box.h"
#include "base/check.h"
#include "geometry/ball.h"

namespace tilecast {

struct Capsule {
  static constexpr int kFaces = 1;
  double radius = 0.5, height = 1.0;  // height: of the cylindrical part; 2 radius more over all
};

inline void check(const Capsule& c) {
  check_positive(c.radius, "radius");
  check_positive(c.height, "height");
}
inline Box bounds(const Capsule& c) {
  Vec3 h{c.radius, 0.5 * c.height + c.radius, c.radius};
  return {-h, h};
}
inline Interval inside(const Capsule& c, const Ray& line) {
  const Vec3 &o = line.origin, &d = line.direction;
  Interval side = inside_ball(Vec2(o.x, o.z), Vec2(d.x, d.z), c.radius, 0);
  if (side.empty) return side;
  Interval whole = Interval::nothing();
  for (double end : {-0.5 * c.height, 0.5 * c.height}) {
    Twofold y = two_sum(o.y, -end);
    Shift<Vec3> shift{Vec3(0.0, y.lo, 0.0), 0.5 * c.height};
    whole.extend(inside_ball(Vec3(o.x, y.hi, o.z), d, c.radius, 0, &shift));
  }
  side.intersect(inside_slab(o.y, d.y, -0.5 * c.height, 0.5 * c.height, 0, 0));
  whole.extend(side);
  return whole;
}
inline Vec3 arm_of(const Capsule& c, const Vec3& p) {
  return Vec3(p.x, p.y - std::clamp(p.y, -0.5 * c.height, 0.5 * c.height), p.z);
}
inline Vec3 outward(const Capsule& c, int, const Vec3& p) { return direction_of(arm_of(c, p), Vec3(1.0, 0.0, 0.0)); }
inline Vec3 project(const Capsule& c, int, const Vec3& p) {
  Vec3 arm = arm_of(c, p);
  return p + (of_length(arm, c.radius, Vec3(c.radius, 0.0, 0.0)) - arm);
}

}  // namespace tilecast
