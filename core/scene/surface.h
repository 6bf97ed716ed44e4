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

// The way down to a primitive, kept: of rays that are near each other many end on the same ones. Belongs to one scene.
class Ways {
 public:
  struct Way {
    uint64_t primitive = Hit::kNone, face;
    const Object* object;
    const Material* material;
    const Instance* instances[4];
    int count;
    Affine product;
    glm::dmat3 inverse;
    const Affine* to_world;
    const glm::dmat3* to_local;
    bool turned;
    double stretch, offsets;
  };

  static constexpr size_t kSlots = 128;

  explicit Ways(const Scene& scene) : scene_(scene) {}
  Ways(const Ways&) = delete;

  static size_t slot_of(uint64_t primitive) { return (primitive * 0x9e3779b97f4a7c15u) >> 57; }

  // Until the next call. The count of instances is 0 where there are more than it has room for.
  const Way& to(uint64_t primitive) {
    Way& way = ways_[slot_of(primitive)];
    if (way.primitive != primitive) find(primitive, way);
    return way;
  }
  // What resolve() gives, to the same bits.
  Surface resolve(const Way& way, const Ray& ray, const Hit& hit) const;

 private:
  void find(uint64_t primitive, Way& way) const;

  const Scene& scene_;
  Way ways_[kSlots];
};

}  // namespace tilecast
