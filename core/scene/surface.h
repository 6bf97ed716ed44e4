// What a hit means: the point, its normal and its material, in world space.
#pragma once

#include "scene/trace.h"

namespace tilecast {

struct Surface {
  Vec3 point;       // world space, metres
  Vec3 normal;      // geometric, outward, unit length
  double error;     // bound on the distance of `point` from the surface, metres
  const Material* material;

  TexturePoint place;   // set only where the material is textured
  Vec3 shading_normal;  // only where it has a normal map: that of the map, outward, world space, unit length
  bool front;           // the same: seen from the side that `normal` points to

  // Where a ray that leaves in this direction starts: off the surface by the error bound, on the direction's side.
  Vec3 spawn(const Vec3& direction) const {
    return point + (glm::dot(direction, normal) >= 0.0 ? error : -error) * normal;
  }
};

Surface resolve(const Scene& scene, const Ray& ray, const Hit& hit);

}  // namespace tilecast
