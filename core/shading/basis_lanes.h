// shading/basis.h for eight normals at once: the same operations, and so the same bits.
#pragma once

#include "base/vec_lanes.h"

namespace tilecast {

struct BasisLanes {
  Vec3Lanes x, y, z;

  explicit BasisLanes(const Vec3Lanes& n) : z(n) {
    const Double8 one = 1.0, sign = copysign(one, n.z), a = -one / (sign + n.z), b = n.x * n.y * a;
    x = {one + sign * n.x * n.x * a, sign * b, -sign * n.x};
    y = {b, sign + n.y * n.y * a, -n.y};
  }
  Vec3Lanes to_local(const Vec3Lanes& v) const { return {dot(v, x), dot(v, y), dot(v, z)}; }
  Vec3Lanes to_world(const Vec3Lanes& v) const { return v.x * x + v.y * y + v.z * z; }
};

}  // namespace tilecast
