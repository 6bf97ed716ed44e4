#include "scene/surface.h"

#include "scene/descend.h"

namespace tilecast {
namespace {

struct Leaf {
  Vec3 point, normal;
  double error;
};

Leaf at_leaf(const Scene& scene, const Object& object, const Ray& ray, const Hit& hit, uint64_t face) {
  Vec3 p = ray.at(hit.t);
  switch (object.kind) {
    case Kind::Mesh: {
      const Mesh& mesh = scene.meshes[object.index].mesh();
      Triangle triangle = mesh.triangle(static_cast<uint32_t>(face));
      Vec3 a(triangle.a), b(triangle.b), c(triangle.c);
      Vec3 e1 = b - a, e2 = c - a;
      return {mesh.frame.from_frame(a + hit.u * e1 + hit.v * e2), glm::cross(e1, e2),
              kSidewaysError * mesh.frame.scale};
    }
    case Kind::Solid: {
      const Solid& solid = scene.solids[object.index];
      p = project(solid, static_cast<int>(face), p);
      return {p, outward(solid, static_cast<int>(face), p), projection_error(solid, p)};
    }
    default:
      return {Vec3(p.x, 0.0, p.z), Vec3(0.0, 1.0, 0.0), 0.0};
  }
}

}  // namespace

Surface resolve(const Scene& scene, const Ray& ray, const Hit& hit) {
  uint64_t primitive = hit.primitive;
  int material = kInherit;
  Ray local = ray;
  Affine product;       // of the transforms down to the object, where there is more than one
  glm::dmat3 inverse;
  const Affine* to_world = &product;
  const glm::dmat3* to_local = &inverse;
  bool turned = false;  // or scaled; otherwise the product's offset is all there is
  double stretch = std::sqrt(3.0);  // of the identity, in the same norm
  double offsets = 0.0;  // magnitudes that the transforms added and took away
  const Object& object = descend<true>(scene, primitive, [&](const Instance& instance) {
    if (instance.material != kInherit) material = instance.material;
    local = instance.local(local);
    offsets += stretch * max_abs(instance.to_parent.offset);
    if (turned) {
      product = *to_world * instance.to_parent;
      inverse = instance.to_local.linear * *to_local;
      to_world = &product, to_local = &inverse;
      stretch = product.stretch();
    } else if (instance.turned) {
      stretch = instance.stretch;
      to_local = &instance.to_local.linear;
      if (product.offset == Vec3(0.0)) {
        to_world = &instance.to_parent;
      } else {
        product = {instance.to_parent.linear, instance.to_parent.offset + product.offset};
      }
      turned = true;
    } else {
      product.offset += instance.to_parent.offset;
    }
  });
  Leaf leaf = at_leaf(scene, object, local, hit, primitive);
  Surface surface;
  surface.local_point = leaf.point;
  surface.local_normal = leaf.normal;
  surface.point = turned ? to_world->point(leaf.point) : leaf.point + product.offset;
  surface.material = &scene.materials[material == kInherit ? 0 : material];
  surface.error = stretch * (leaf.error + 16 * kUnitRoundoff * max_abs(leaf.point)) +
                  16 * kUnitRoundoff * (max_abs(surface.point) + offsets);
  Vec3 normal = turned ? leaf.normal * *to_local : leaf.normal;
  double largest = max_abs(normal);
  surface.normal = largest > 0.0 ? glm::normalize(normal * power_below_reciprocal(largest)) : -glm::normalize(ray.direction);
  if ((glm::dot(surface.normal, ray.direction) > 0.0) == hit.entering) {
    surface.normal = -surface.normal;
    surface.local_normal = -surface.local_normal;
  }
  return surface;
}

}  // namespace tilecast
