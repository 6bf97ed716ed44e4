// A cylinder about y, centred, closed by two disks: the side's interval, cut by a slab. Faces: 0 side, 1 bottom, 2 top.
#pragma once

#include "base/box.h"
#include "base/check.h"
#include "geometry/ball.h"

namespace tilecast {

struct Cylinder {
  static constexpr int kFaces = 3;
  double radius = 1.0, height = 2.0;
};

inline void check(const Cylinder& c) {
  check_positive(c.radius, "radius");
  check_positive(c.height, "height");
}
inline Box bounds(const Cylinder& c) {
  Vec3 h{c.radius, 0.5 * c.height, c.radius};
  return {-h, h};
}
inline Interval inside(const Cylinder& c, const Ray& line) {
  const Vec3 &o = line.origin, &d = line.direction;
  Interval interval = inside_slab(o.y, d.y, -0.5 * c.height, 0.5 * c.height, 1, 2);
  if (!interval.empty) interval.intersect(inside_ball(Vec2(o.x, o.z), Vec2(d.x, d.z), c.radius, 0));
  return interval;
}
inline Vec3 outward(const Cylinder&, int face, const Vec3& p) {
  return face == 0 ? Vec3(p.x, 0.0, p.z) : Vec3(0.0, face == 1 ? -1.0 : 1.0, 0.0);
}
inline Vec3 project(const Cylinder& c, int face, const Vec3& p) {
  if (face != 0) return Vec3(p.x, face == 1 ? -0.5 * c.height : 0.5 * c.height, p.z);
  Vec2 side = of_length(Vec2(p.x, p.z), c.radius, Vec2(c.radius, 0.0));
  return Vec3(side.x, p.y, side.y);
}

}  // namespace tilecast
