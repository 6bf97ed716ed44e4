// A general quadric, closed by a box: the points of the box where a polynomial of second degree is negative.
// Faces: 0 the quadric, 1 to 6 those of the box.
#pragma once

#include <array>

#include "base/box.h"
#include "geometry/interval.h"

namespace tilecast {

struct Quadric {
  static constexpr int kFaces = 7;
  // Of x^2, y^2, z^2, xy, xz, yz, x, y, z and 1, for coordinates in `unit`s; the largest is near 1.
  std::array<double, 10> coefficients;
  double unit;  // metres, a power of two; the box lies within one
  Vec3 lo, hi;  // metres

  // For coordinates in metres. Refuses what is not finite, and a polynomial that is constant.
  static Quadric of(std::array<double, 10> coefficients, const Vec3& lo, const Vec3& hi);
};

inline void check(const Quadric&) {}
inline Box bounds(const Quadric& q) { return {q.lo, q.hi}; }
Intervals inside(const Quadric& q, const Ray& line);
Vec3 outward(const Quadric& q, int face, const Vec3& p);
Vec3 project(const Quadric& q, int face, const Vec3& p);

}  // namespace tilecast
