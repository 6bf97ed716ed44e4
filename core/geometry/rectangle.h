// An open rectangle in the xz plane, centred, facing +y.
#pragma once

#include "base/ray.h"

namespace tilecast {

struct Rectangle {
  double width = 1.0, depth = 1.0;  // along x and z, metres
};

// The parameter at which the line crosses it; half open, so that rectangles side by side are hit once. In the plane: a miss.
inline bool intersect(const Rectangle& r, const Ray& line, double& t) {
  if (line.direction.y == 0.0) return false;
  t = -line.origin.y / line.direction.y;
  double x = std::fma(t, line.direction.x, line.origin.x), z = std::fma(t, line.direction.z, line.origin.z);
  return -0.5 * r.width <= x && x < 0.5 * r.width && -0.5 * r.depth <= z && z < 0.5 * r.depth;
}

}  // namespace tilecast
