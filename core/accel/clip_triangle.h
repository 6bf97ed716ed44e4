// The box of what of a triangle lies in a region: what spatial splits and cells are made of.
//
// Sutherland and Hodgman, "Reentrant Polygon Clipping", CACM 17(1), 1974, in double. The box is rounded outwards; what
// rounding may move a corner by (2^-50) is far within kBoxPadding.
#pragma once

#include "geometry/triangle.h"

namespace tilecast {

// [box_lo, box_hi]: the region on entry, the box on return. False where nothing lies within.
inline bool clip_triangle(const Triangle& triangle, float box_lo[3], float box_hi[3]) {
  Vec3 polygon[9] = {Vec3(triangle.a), Vec3(triangle.b), Vec3(triangle.c)}, clipped[9];
  int count = 3;
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side) {
      const double plane = side ? box_hi[axis] : box_lo[axis], sign = side ? -1.0 : 1.0;
      double least = 0.0;
      for (int i = 0; i < count; ++i) least = std::min(least, sign * (polygon[i][axis] - plane));
      if (least == 0.0) continue;  // all of it is on the plane's inner side
      int kept = 0;
      for (int i = 0; i < count; ++i) {
        const Vec3 &a = polygon[i], &b = polygon[i + 1 < count ? i + 1 : 0];
        const double da = sign * (a[axis] - plane), db = sign * (b[axis] - plane);
        if (da >= 0.0) clipped[kept++] = a;
        if ((da < 0.0) != (db < 0.0) && da != 0.0 && db != 0.0) {
          Vec3 p = a + da / (da - db) * (b - a);
          p[axis] = plane;
          clipped[kept++] = p;
        }
      }
      count = kept;
      if (count == 0) return false;
      std::copy_n(clipped, count, polygon);
    }
  Vec3 lo = polygon[0], hi = polygon[0];
  for (int i = 1; i < count; ++i) lo = glm::min(lo, polygon[i]), hi = glm::max(hi, polygon[i]);
  for (int i = 0; i < 3; ++i) {
    float l = static_cast<float>(lo[i]), h = static_cast<float>(hi[i]);
    box_lo[i] = l > lo[i] ? std::nextafter(l, -4.0f) : l;
    box_hi[i] = h < hi[i] ? std::nextafter(h, 4.0f) : h;
  }
  return true;
}

}  // namespace tilecast
