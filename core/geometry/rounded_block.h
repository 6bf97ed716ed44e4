// A box whose edges and corners are rounded off: all that lies within `radius` of the box `radius` inside it.
// Faces: those of the box where it is flat, and 6 for all that is round.
//
// Convex, so a line's interval is the hull of those of its parts: three boxes, a cylinder along each edge of the inner
// box and a ball about each of its corners.
#pragma once

#include "base/box.h"
#include "geometry/interval.h"

namespace tilecast {

struct RoundedBlock {
  static constexpr int kFaces = 7;
  Vec3 lo{-1.0}, hi{1.0};  // of the whole
  double radius = 0.1;
};

void check(const RoundedBlock& b);
Box bounds(const RoundedBlock& b);
Interval inside(const RoundedBlock& b, const Ray& line);
Vec3 outward(const RoundedBlock& b, int face, const Vec3& p);
Vec3 project(const RoundedBlock& b, int face, const Vec3& p);

}  // namespace tilecast
