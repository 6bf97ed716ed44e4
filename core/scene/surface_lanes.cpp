#include "scene/surface_lanes.h"

#include "geometry/sure_lanes.h"
#include "scene/descend.h"

namespace tilecast {
namespace {

// As project(), outward() and projection_error() of geometry/solid.h and its parts, and for flats.
void at_leaf(const Scene& scene, const Ways::Way& way, Vec3Lanes& p, Vec3Lanes& normal, Double8& error) {
  const int face = static_cast<int>(way.face);
  if (kind_of(*way.object) == Kind::Flat) {
    p.y = Double8(0.0), normal = Vec3Lanes(Vec3(0.0, 1.0, 0.0)), error = Double8(0.0);
    return;
  }
  const Solid& solid = scene.solids[way.object->index];
  if (auto* sphere = std::get_if<Sphere>(&solid)) {
    const Double8 now = sqrt(dot(p, p));
    p = choose(now > 0.0, p * (Double8(sphere->radius) / now), Vec3Lanes(Vec3(0.0, sphere->radius, 0.0)));
    normal = p;
  } else if (auto* block = std::get_if<Block>(&solid)) {
    const double end = (face & 1 ? block->hi : block->lo)[face / 2];
    (face / 2 == 0 ? p.x : face / 2 == 1 ? p.y : p.z) = Double8(end);
    normal = Vec3Lanes(block_outward(face));
  } else {
    const Cylinder& cylinder = std::get<Cylinder>(solid);
    if (face != 0) {
      p.y = Double8(face == 1 ? -0.5 * cylinder.height : 0.5 * cylinder.height);
      normal = Vec3Lanes(Vec3(0.0, face == 1 ? -1.0 : 1.0, 0.0));
    } else {
      const Double8 now = sqrt(p.x * p.x + p.z * p.z), longer = Double8(cylinder.radius) / now;
      const Mask8d off_axis = now > 0.0;
      p.x = choose(off_axis, p.x * longer, cylinder.radius), p.z = choose(off_axis, p.z * longer, 0.0);
      normal = {p.x, Double8(0.0), p.z};
    }
  }
  error = Double8(16 * kUnitRoundoff) * max_abs(p);
}

}  // namespace

bool has_lanes(const Scene& scene, const Ways::Way& way) {
  if (way.count == 0) return false;
  const Kind kind = kind_of(*way.object);
  return kind == Kind::Flat || (kind == Kind::Solid && has_sure_lanes(scene.solids[way.object->index]));
}

SurfaceLanes resolve(const Scene& scene, const Ways::Way& way, const Vec3Lanes& origin, const Vec3Lanes& direction,
                     const Double8& t, bool entering) {
  SurfaceLanes out;
  Vec3Lanes o = origin, d = direction;
  for (int i = 0; i < way.count; ++i) {
    const Instance& instance = *way.instances[i];
    o = o - Vec3Lanes(instance.to_local.origin);
    if (!instance.turned) continue;
    o = multiply_add(instance.to_local.linear, o, Vec3(0.0)), d = multiply_add(instance.to_local.linear, d, Vec3(0.0));
  }
  Vec3Lanes p = o + t * d, normal;
  Double8 error;
  at_leaf(scene, way, p, normal, error);
  out.place = p, out.place_normal = normal;
  out.point = way.turned ? multiply_add(way.to_world->linear, p, way.to_world->offset) : p + Vec3Lanes(way.product.offset);
  out.error = Double8(way.stretch) * (error + Double8(16 * kUnitRoundoff) * max_abs(p)) +
              Double8(16 * kUnitRoundoff) * (max_abs(out.point) + Double8(way.offsets));
  if (way.turned) normal = normal * *way.to_local;
  const Double8 largest = max_abs(normal);
  out.known = bits(largest > 0.0);
  normal = normalize(normal * power_below_reciprocal(largest));
  const Mask8d ahead = dot(normal, direction) > 0.0, flipped = entering ? ahead : ~ahead;
  out.normal = choose(flipped, -normal, normal);
  out.place_normal = choose(flipped, -out.place_normal, out.place_normal);
  return out;
}

}  // namespace tilecast
