// The solids, each as the intervals in which a whole line is inside it, in double.
//
// A solid is centred at the origin of its own space. Sphere: Haines, Gunther and Akenine-Moller, "Precision
// Improvements for Ray/Sphere Intersection", Ray Tracing Gems (2019), chapter 7; the cylinder's side likewise in its
// plane; cylinder and box are intersections of intervals, so a rim can never be crossed an odd number of times.
#pragma once

#include <variant>

#include "base/box.h"
#include "base/ray.h"

namespace tilecast {

struct Sphere {
  double radius = 1.0;
};
struct Block {  // the axis-aligned box
  Vec3 lo{-1.0}, hi{1.0};
};
struct Cylinder {  // about y, closed by two disks
  double radius = 1.0, height = 2.0;
};
using Solid = std::variant<Sphere, Block, Cylinder>;

struct SolidCrossing {
  double t;
  double error;  // bound on the error of t
  int face;      // Sphere: 0. Block: 2 * axis, + 1 at the upper end. Cylinder: 0 side, 1 bottom, 2 top
  bool entering;
};
inline constexpr int kMaxSolidCrossings = 2;

// All crossings of the whole line, sorted, entries and exits in turn. Returns how many.
int crossings(const Solid& solid, const Ray& line, SolidCrossing out[kMaxSolidCrossings]);

// Outward, of any length, at a point of the given face.
Vec3 outward(const Solid& solid, int face, const Vec3& p);

// A point near the face moved onto it.
Vec3 project(const Solid& solid, int face, const Vec3& p);

Box bounds(const Solid& solid);
int face_count(const Solid& solid);

}  // namespace tilecast
