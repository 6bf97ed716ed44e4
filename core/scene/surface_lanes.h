// What scene/surface.h tells of a hit, of eight at once that lie on one primitive: to the same bits.
#pragma once

#include "base/vec_lanes.h"
#include "scene/surface.h"

namespace tilecast {

struct SurfaceLanes {
  Vec3Lanes point, normal;
  Double8 error;
  Vec3Lanes place, place_normal;  // in the object's space, for textures
  uint32_t known;                 // one bit a lane; the others are for resolve()

  Vec3Lanes spawn(const Vec3Lanes& direction) const {
    return point + choose(dot(direction, normal) >= 0.0, error, -error) * normal;
  }
};

// Whether there are lanes for what the way leads to.
bool has_lanes(const Scene& scene, const Ways::Way& way);

// Rays and t of hits that all enter, or all do not.
SurfaceLanes resolve(const Scene& scene, const Ways::Way& way, const Vec3Lanes& origin, const Vec3Lanes& direction,
                     const Double8& t, bool entering);

}  // namespace tilecast
