// shading/basis.h for several normals at once: the same operations, and so the same bits. V: Vec3x4 or Vec3Lanes.
#pragma once

#include "base/vec_lanes.h"

namespace tilecast {

template <class V>
struct BasisLanes {
  V x, y, z;

  explicit BasisLanes(const V& n) : z(n) {
    using D = decltype(V::x);
    const D sign = copysign(D{} + 1.0, n.z), a = -1.0 / (sign + n.z), b = n.x * n.y * a;
    x = {1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x};
    y = {b, sign + n.y * n.y * a, -n.y};
  }
  V to_local(const V& v) const { return {dot(v, x), dot(v, y), dot(v, z)}; }
  V to_world(const V& v) const { return v.x * x + v.y * y + v.z * z; }
};

}  // namespace tilecast
