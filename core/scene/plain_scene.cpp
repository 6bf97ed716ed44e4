#include "scene/plain_scene.h"

#include "base/built.h"

namespace tilecast {
namespace {

enum class Finish : uint8_t { Chalk, Mirror, Glass };

// Nothing where it is none of these.
std::optional<Finish> finish_of(const Material& m) {
  if (m.textured || m.normal_map >= 0 || m.opacity < 1.0) return {};
  if (m.kind == MaterialKind::Diffuse && m.roughness == 0.0) return Finish::Chalk;
  if (built_with("mirror") && m.kind == MaterialKind::Mirror) return Finish::Mirror;
  if (built_with("dielectric") && m.kind == MaterialKind::Dielectric && m.refracts && m.smooth() && m.dispersion == 0.0 &&
      !m.emits())
    return Finish::Glass;
  return {};
}

// As resolve() finds it, but for the side of the viewer.
Vec3 world_normal(const Instance& instance, const Vec3& leaf) {
  const Vec3 normal = instance.turned ? leaf * instance.to_local.linear : leaf;
  return glm::normalize(normal * power_below_reciprocal(max_abs(normal)));
}

constexpr uint64_t all_bits(bool yes) { return yes ? ~uint64_t(0) : 0; }

// But for where it lies.
PlainScene::Face face_of(const Instance& instance, const Material& material, Finish finish, double leaf_error) {
  PlainScene::Face face{};
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      face.to_local[i].m[k] = instance.to_local.linear[k][i];
      face.to_world[i].m[k] = instance.to_parent.linear[k][i];
    }
    face.to_local[i].offset = instance.to_local.origin[i];
    face.to_world[i].offset = instance.to_parent.offset[i];
    face.reflectance[i] = (finish == Finish::Glass ? material.tint : material.reflectance)[i];
    face.emission[i] = material.emission[i];
  }
  face.stretch = instance.turned ? instance.stretch : std::sqrt(3.0);
  face.leaf_error = leaf_error;
  face.offsets = std::sqrt(3.0) * max_abs(instance.to_parent.offset);
  face.emits = material.emits();
  face.mirror = all_bits(finish == Finish::Mirror), face.glass = all_bits(finish == Finish::Glass);
  std::fill(std::begin(face.turned), std::end(face.turned), all_bits(instance.turned));
  return face;
}

void lay(PlainScene::Face& face, const Instance& instance, int axis, double plane, const Vec3& outward) {
  const Vec3 normal = world_normal(instance, outward);
  for (int i = 0; i < 3; ++i) face.normal[i] = normal[i];
  face.across[axis] = all_bits(true);
  face.plane[axis] = plane;
}

}  // namespace

std::optional<PlainScene> PlainScene::of(const Scene& scene) {
  const Lights& lights = scene.lights;
  const bool sampled = scene.next_event && lights.count() > 0;
  if ((scene.integrator != Integrator::Path && scene.integrator != Integrator::Direct) || scene.contrast > 0.0 ||
      lights.environment || !built_with("rectangle") || !built_with("solid") || !built_with("area_lights") ||
      !built_with("emission") || !built_with("shadow_rays") || scene.objects[scene.root].kind != Kind::Group)
    return {};
  if (sampled && (lights.count() > 1 || lights.areas.empty() || lights.areas[0].pieces.size() > 1 ||
                  lights.areas[0].shape != AreaLight::Shape::Parallelogram))
    return {};
  const Assembly& group = scene.groups[scene.objects[scene.root].index];
  if (group.instances.size() > kMostObjects) return {};
  PlainScene out;
  for (size_t i = 0; i < group.instances.size(); ++i) {
    const Instance& instance = group.instances[i];
    const Object& object = scene.objects[instance.object];
    const Material& material = scene.materials[instance.material == kInherit ? 0 : instance.material];
    const std::optional<Finish> finish = finish_of(material);
    if (!finish) return {};
    if (*finish == Finish::Glass) {
      if (out.glass && out.glass != &material) return {};
      out.glass = &material;
    }
    if (*finish != Finish::Chalk) out.chalk = false;
    Shape plain{};
    for (int c = 0; c < 3; ++c) {
      for (int k = 0; k < 3; ++k) plain.to_local[c][k] = all(instance.to_local.linear[k][c]);
      plain.origin[c] = all(instance.to_local.origin[c]);
    }
    plain.face = static_cast<int64_t>(out.faces.size());
    if (object.kind == Kind::Flat) {
      const Rectangle* rectangle = std::get_if<Rectangle>(&scene.flats[object.index]);
      if (!rectangle) return {};
      plain.lo[0] = all(-0.5 * rectangle->width), plain.hi[0] = all(0.5 * rectangle->width);
      plain.lo[2] = all(-0.5 * rectangle->depth), plain.hi[2] = all(0.5 * rectangle->depth);
      Face& face = out.faces.emplace_back(face_of(instance, material, *finish, 0.0));
      lay(face, instance, 1, 0.0, Vec3(0.0, 1.0, 0.0));
      if (sampled && lights.find(group.first_primitive[i]) >= 0) face.area = lights.areas[0].area();
    } else if (object.kind != Kind::Solid) {
      return {};
    } else if (const Block* block = std::get_if<Block>(&scene.solids[object.index])) {
      plain.kind = Shape::Kind::Box;
      for (int c = 0; c < 3; ++c) plain.lo[c] = all(block->lo[c]), plain.hi[c] = all(block->hi[c]);
      for (int face = 0; face < Block::kFaces; ++face)
        lay(out.faces.emplace_back(face_of(instance, material, *finish, 16 * kUnitRoundoff)), instance, face / 2,
            (face & 1 ? block->hi : block->lo)[face / 2], block_outward(face));
    } else if (const Sphere* ball = std::get_if<Sphere>(&scene.solids[object.index])) {
      plain.kind = Shape::Kind::Ball;
      plain.radius = ball->radius;
      Face& face = out.faces.emplace_back(face_of(instance, material, *finish, 16 * kUnitRoundoff));
      face.round = all_bits(true), face.radius = ball->radius;
      out.chalk = false;
    } else {
      return {};
    }
    out.shapes.push_back(plain);
  }
  if (sampled) {
    const AreaLight& area = lights.areas[0];
    const LightSample at = sample(area, 0.0, Vec2(0.0));
    const AreaLight::Piece& piece = area.pieces[0];
    out.lamp = Lamp{piece.origin, piece.edge1, piece.edge2, at.normal, at.error * at.normal,
                    area.area(), lights.probability(lights.first_area(), {}), area.radiance};
  }
  return out;
}

}  // namespace tilecast
