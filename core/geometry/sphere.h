// A ball about the origin.
#pragma once

#include "base/box.h"
#include "base/check.h"
#include "geometry/ball.h"

namespace tilecast {

struct Sphere {
  static constexpr int kFaces = 1;
  double radius = 1.0;
};

inline void check(const Sphere& s) { check_positive(s.radius, "radius"); }
inline Box bounds(const Sphere& s) { return {Vec3(-s.radius), Vec3(s.radius)}; }
inline Interval inside(const Sphere& s, const Ray& line) {
  return inside_ball(line.origin, line.direction, s.radius, 0);
}
inline Vec3 outward(const Sphere&, int, const Vec3& p) { return p; }
inline Vec3 project(const Sphere& s, int, const Vec3& p) { return of_length(p, s.radius, Vec3(0.0, s.radius, 0.0)); }

}  // namespace tilecast
