// A cone or frustum about y, centred, closed by disks. Faces: 0 side, 1 bottom, 2 top.
//
// The side is where (height rho)^2 < w^2, w = height * radius at the point's y: a quadric of two nappes, of which a
// line meets the one with w > 0 in an interval; the slab between the disks cuts it. At the apex both end in one point.
#pragma once

#include "base/box.h"
#include "base/check.h"
#include "geometry/interval.h"

namespace tilecast {

struct Cone {
  static constexpr int kFaces = 3;
  double radius = 1.0, top_radius = 0.0, height = 2.0;  // radius: of the bottom
};

void check(const Cone& c);
Box bounds(const Cone& c);
Interval inside(const Cone& c, const Ray& line);
Vec3 outward(const Cone& c, int face, const Vec3& p);
Vec3 project(const Cone& c, int face, const Vec3& p);

}  // namespace tilecast
