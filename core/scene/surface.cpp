#include "scene/surface.h"

#include "scene/descend.h"
#include "scene/parametrisation.h"

namespace tilecast {
namespace {

struct Leaf {
  Vec3 point, normal;
  double error;
};

[[gnu::always_inline]] inline Leaf at_leaf(const Scene& scene, const Object& object, const Ray& ray, const Hit& hit, uint64_t face) {
  Vec3 p = ray.at(hit.t);
  switch (kind_of(object)) {
    case Kind::Mesh: {
      const Mesh& mesh = scene.meshes[object.index].mesh();
      Triangle triangle = mesh.triangle(static_cast<uint32_t>(face));
      Vec3 a(triangle.a), b(triangle.b), c(triangle.c);
      Vec3 e1 = b - a, e2 = c - a;
      return {mesh.frame.from_frame(a + hit.u * e1 + hit.v * e2), glm::cross(e1, e2),
              mesh.frame.sideways_error()};
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

// By the corners' texture coordinates. Without any, as where no texture asks for them, all is 0.
Parametrisation parametrisation(const Mesh& mesh, const std::vector<FaceUvs>& uvs, uint32_t face, const Hit& hit) {
  if (uvs.empty()) return {Vec2(0.0)};
  const Vec2 a(uvs[face][0]), d1 = Vec2(uvs[face][1]) - a, d2 = Vec2(uvs[face][2]) - a;
  Triangle triangle = mesh.triangle(face);
  const Vec3 e1 = Vec3(triangle.b) - Vec3(triangle.a), e2 = Vec3(triangle.c) - Vec3(triangle.a);
  const double area = d1.x * d2.y - d1.y * d2.x, sign = area > 0.0 ? 1.0 : area < 0.0 ? -1.0 : 0.0;
  return {a + hit.u * d1 + hit.v * d2, sign * (d2.y * e1 - d1.y * e2), sign * (d1.x * e2 - d2.x * e1)};
}

Parametrisation parametrisation(const Scene& scene, const Object& object, const Hit& hit, uint64_t face, const Vec3& p) {
  switch (object.kind) {
    case Kind::Mesh:
      return parametrisation(scene.meshes[object.index].mesh(), scene.mesh_uvs[object.index], static_cast<uint32_t>(face), hit);
    case Kind::Solid: return parametrisation(scene.solids[object.index], static_cast<int>(face), p);
    default: return parametrisation(scene.flats[object.index], p);
  }
}

// The normal that a map gives, in the frame of the normal and of what is left across it of the direction of u.
// du, dv: world space.
Vec3 mapped_normal(const Vec3& map, const Vec3& n, const Vec3& du, const Vec3& dv) {
  Vec3 t = du - glm::dot(du, n) * n;
  const double largest = max_abs(t);
  if (!(largest > 0.0)) return n;  // a pole, or a triangle without room in the image
  t = glm::normalize(t * power_below_reciprocal(largest));
  const Vec3 side = glm::cross(n, t), b = glm::dot(side, dv) < 0.0 ? -side : side;
  const Vec3 m = 2.0 * map - 1.0;
  const Vec3 mapped = m.x * t + m.y * b + std::max(m.z, 1e-3) * n;  // never from behind
  return glm::normalize(mapped);
}

// What textures want to know. Apart: most materials have none.
[[gnu::noinline]] void place_textures(const Scene& scene, const Object& object, const Hit& hit, uint64_t face,
                                      const Leaf& leaf, const glm::dmat3& to_world, bool flipped, Surface& surface) {
  surface.place = {leaf.point, flipped ? -leaf.normal : leaf.normal, Vec2(0.0)};
  if (!surface.material->uses_uv) return;
  const Parametrisation found = parametrisation(scene, object, hit, face, leaf.point);
  surface.place.uv = found.uv;
  if (!built_with("normal_map") || surface.material->normal_map < 0) return;
  surface.front = hit.entering;
  surface.shading_normal = mapped_normal(at(scene.textures[surface.material->normal_map], surface.place), surface.normal,
                                         to_world * found.du, to_world * found.dv);
}

// An object's transforms on the way down to it, put together.
struct Placed {
  Affine product;       // where there is more than one
  glm::dmat3 inverse;
  const Affine* to_world = &product;
  const glm::dmat3* to_local = &inverse;
  bool turned = false;  // or scaled; otherwise the product's offset is all there is
  double stretch = std::sqrt(3.0);  // of the identity, in the same norm
  double offsets = 0.0;  // magnitudes that the transforms added and took away

  [[gnu::always_inline]] void enter(const Instance& instance) {
    offsets += stretch * max_abs(instance.to_parent.offset);
    if (turned && !instance.turned) {
      product = {to_world->linear, to_world->point(instance.to_parent.offset)};
      to_world = &product;
    } else if (turned) {
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
  }
};

// P: a Placed or a Way.
template <class P>
[[gnu::always_inline]] inline Surface surface_of(const Scene& scene, const Object& object, const P& placed, const Material& material,
                          const Ray& ray, const Ray& local, const Hit& hit, uint64_t face) {
  Leaf leaf = at_leaf(scene, object, local, hit, face);
  Surface surface;
  surface.point = placed.turned ? placed.to_world->point(leaf.point) : leaf.point + placed.product.offset;
  surface.material = &material;
  surface.error = placed.stretch * (leaf.error + 16 * kUnitRoundoff * max_abs(leaf.point)) +
                  16 * kUnitRoundoff * (max_abs(surface.point) + placed.offsets);
  Vec3 normal = placed.turned ? leaf.normal * *placed.to_local : leaf.normal;
  double largest = max_abs(normal);
  surface.normal = largest > 0.0 ? glm::normalize(normal * power_below_reciprocal(largest)) : -glm::normalize(ray.direction);
  const bool flipped = (glm::dot(surface.normal, ray.direction) > 0.0) == hit.entering;
  if (flipped) surface.normal = -surface.normal;
  if (built_with("texture") && surface.material->textured)
    place_textures(scene, object, hit, face, leaf, placed.turned ? placed.to_world->linear : glm::dmat3(1.0), flipped, surface);
  return surface;
}

}  // namespace

Surface resolve(const Scene& scene, const Ray& ray, const Hit& hit) {
  uint64_t primitive = hit.primitive;
  int material = kInherit;
  Ray local = ray;
  Placed placed;
  const Object& object = descend<true>(scene, primitive, [&](const Instance& instance) {
    if (instance.material != kInherit) material = instance.material;
    local = instance.local(local);
    placed.enter(instance);
  });
  return surface_of(scene, object, placed, scene.materials[material == kInherit ? 0 : material], ray, local, hit, primitive);
}

void Ways::find(uint64_t primitive, Way& way) const {
  way.primitive = way.face = primitive;
  way.count = 0;
  int material = kInherit;
  Placed placed;
  bool room = true;
  way.object = &descend<true>(scene_, way.face, [&](const Instance& instance) {
    if (instance.material != kInherit) material = instance.material;
    placed.enter(instance);
    room &= way.count < static_cast<int>(std::size(way.instances));
    if (room) way.instances[way.count++] = &instance;
  });
  if (!room) way.count = 0;
  way.material = &scene_.materials[material == kInherit ? 0 : material];
  way.product = placed.product, way.inverse = placed.inverse;
  way.to_world = placed.to_world == &placed.product ? &way.product : placed.to_world;
  way.to_local = placed.to_local == &placed.inverse ? &way.inverse : placed.to_local;
  way.turned = placed.turned, way.stretch = placed.stretch, way.offsets = placed.offsets;
}

Surface Ways::resolve(const Way& way, const Ray& ray, const Hit& hit) const {
  if (way.count == 0) return tilecast::resolve(scene_, ray, hit);
  Ray local = ray;
  for (int i = 0; i < way.count; ++i) local = way.instances[i]->local(local);
  return surface_of(scene_, *way.object, way, *way.material, ray, local, hit, way.face);
}

}  // namespace tilecast
