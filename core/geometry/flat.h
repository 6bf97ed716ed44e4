// Open surfaces in the xz plane, centred, facing +y.
#pragma once

#include <variant>

#include "base/box.h"
#include "base/check.h"
#include "base/ray.h"

namespace tilecast {

struct Rectangle {
  double width = 1.0, depth = 1.0;  // along x and z, metres
};
struct Disk {
  double radius = 1.0;
};
using Flat = std::variant<Rectangle, Disk>;

inline void check(const Rectangle& r) {
  check_positive(r.width, "size[0]");
  check_positive(r.depth, "size[1]");
}
inline void check(const Disk& d) { check_positive(d.radius, "radius"); }

inline Box bounds(const Rectangle& r) {
  Vec3 h{0.5 * r.width, 0.0, 0.5 * r.depth};
  return {-h, h};
}
inline Box bounds(const Disk& d) {
  Vec3 h{d.radius, 0.0, d.radius};
  return {-h, h};
}

// Half open, so that rectangles side by side are hit once.
inline bool covers(const Rectangle& r, double x, double z) {
  return -0.5 * r.width <= x && x < 0.5 * r.width && -0.5 * r.depth <= z && z < 0.5 * r.depth;
}
inline bool covers(const Disk& d, double x, double z) { return x * x + z * z < d.radius * d.radius; }

inline bool covers(const Flat& flat, double x, double z) {
  return std::visit([&](const auto& shape) { return covers(shape, x, z); }, flat);
}

// The parameter at which the line crosses it. In the plane: a miss.
inline bool intersect(const Flat& flat, const Ray& line, double& t) {
  if (line.direction.y == 0.0) return false;
  t = -line.origin.y / line.direction.y;
  return covers(flat, std::fma(t, line.direction.x, line.origin.x), std::fma(t, line.direction.z, line.origin.z));
}

}  // namespace tilecast
