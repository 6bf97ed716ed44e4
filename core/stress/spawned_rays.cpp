// Gates 9 to 11: where rays start and end. A spawned ray does not meet the surface that it leaves, nor does a shadow ray
// meet its light; neither misses what is close by.
#include "integrators/direct.h"
#include "stress/scenes.h"
#include "stress/shapes.h"
#include "stress/stress.h"

namespace tilecast::stress {
namespace {

constexpr int kRays = 64;  // with each scene

// case_figure(random, scene of make(random)) summed over the cases; a new scene every kRays.
template <class Make, class CaseFigure>
auto over_scenes(Make make, CaseFigure case_figure) {
  return [=](uint64_t first, uint64_t count) {
    Random random(first);
    double sum = 0.0;
    for (uint64_t i = 0; i < count; i += kRays) {
      const auto made = make(random);
      for (uint64_t k = i; k < std::min(count, i + kRays); ++k) sum += case_figure(random, made);
    }
    return sum;
  };
}

// A turn, one scale for all axes or one for each, and a move of up to 100 sizes.
Affine random_place(Random& random, double size, bool similar) {
  const Vec3 factors = similar ? Vec3(1.0) : Vec3(uniform(random, 0.3, 1), uniform(random, 0.3, 1), uniform(random, 0.3, 1));
  const Vec3 away = size * power_of_ten(random, -2, 2) * random_direction(random);
  return translate(away) * rotate(uniform(random, 0, 6), random_direction(random)) * scale(factors);
}

Vec3 direction_from(const Vec3& normal, double cosine, Random& random) {
  const Vec3 aside = glm::normalize(glm::cross(normal, random_direction(random)));
  return glm::normalize(cosine * normal + std::sqrt((1.0 - cosine) * (1.0 + cosine)) * aside);
}

// --- Gate 9: convex bodies of size 1e-8 to 1e8. Outwards nothing is met, at whatever angle; inwards the body is left on
// another face, or on this one no sooner than its curvature allows.

struct Body {
  std::shared_ptr<const Scene> scene;
  Affine place;
  double size, radius;  // radius: of curvature, at least; 0: faces are flat; negative: not looked at from inside
};

Body random_body(Random& random) {
  static const MeshSource kBall = icosphere(2);
  const double size = power_of_ten(random, -8, 8);
  SceneBuilder builder;
  const int kind = random() % 8;
  uint32_t object;
  double radius = 0.0;
  const double height = size * uniform(random, 0.1, 2);
  switch (kind) {
    case 0: object = builder.add_solid(Sphere{size}), radius = size; break;
    case 1: object = builder.add_solid(Block{-size * Vec3(1.0, 0.7, 0.2), Vec3(size)}); break;
    case 2: object = builder.add_solid(Cylinder{size, height}), radius = size; break;
    case 3: object = builder.add_solid(Cone{size, size * uniform(random, 0, 0.9), height}), radius = -1.0; break;
    case 4: object = builder.add_solid(Capsule{size, height}), radius = -1.0; break;
    case 5: object = builder.add_solid(RoundedBlock{Vec3(-size), Vec3(size), size * uniform(random, 0.1, 0.9)}), radius = -1.0; break;
    case 6: object = builder.add_mesh(kBall.transformed(size, Vec3(0.0)).build(), "auto"); break;
    default: object = random() & 1 ? builder.add_rectangle(size, size) : builder.add_flat(Disk{size}), radius = -1.0;
  }
  const Affine place = random_place(random, size, kind == 0 || kind == 2);
  return {scene_of(builder, {{object, place}}), place, size, radius};
}

double meets_itself(Random& random, const Body& body) {
  const Vec3 target = body.place.point(0.5 * body.size * random_direction(random));
  const Vec3 way = random_direction(random);
  const Ray ray{target - body.size * power_of_ten(random, 0.7, 4) * way, way};
  const Hit hit = closest(*body.scene, ray);
  if (!hit.found()) return 0.0;
  const Surface surface = resolve(*body.scene, ray, hit);
  if (body.radius < 0.0 || random() & 1) {
    const double cosine = random() & 1 ? power_of_ten(random, -12, 0) : uniform(random, 0, 1);
    const Vec3 side = hit.entering ? surface.normal : -surface.normal;
    const Vec3 out = direction_from(side, cosine, random);
    return closest(*body.scene, {surface.spawn(out), out}).found();
  }
  const double cosine = uniform(random, 0.01, 1);
  const Vec3 in = direction_from(-surface.normal, cosine, random);
  const Hit exit = closest(*body.scene, {surface.spawn(in), in});
  return !exit.found() || exit.entering || (exit.primitive == hit.primitive && exit.t < body.radius * cosine) ||
         (exit.primitive == hit.primitive && body.radius == 0.0);
}

// --- Gate 10: a plate, and a second one 64 u of the position further on; a ball inside a shell. u is that of the type
// that decides: double, and float for meshes.

struct Gap {
  std::shared_ptr<const Scene> first, both;
  Vec3 centre, normal;  // normal: towards the second one
  double size;
};

MeshSource plate() { return {{{-0.5, 0, -0.5}, {0.5, 0, -0.5}, {0.5, 0, 0.5}, {-0.5, 0, 0.5}}, {{0, 2, 1}, {0, 3, 2}}}; }

Gap random_gap(Random& random) {
  const int kind = random() % 3;
  const double far = power_of_ten(random, -8, 8), size = far * power_of_ten(random, -4, -1);
  const Vec3 centre = far * random_direction(random);
  const Affine turn = rotate(uniform(random, 0, 6), random_direction(random));
  const Vec3 normal = turn.vector(Vec3(0, 1, 0));
  const double mesh_gap = 64 * 0x1p-24 * size, gap = 64 * kUnitRoundoff * max_abs(centre) + (kind == 2 ? mesh_gap : 0.0);
  Gap out{nullptr, nullptr, centre, normal, size};
  for (bool with_second : {false, true}) {
    SceneBuilder builder;
    std::vector<InstanceSource> list;
    auto put = [&](double along, double by) {
      uint32_t object = kind == 0   ? builder.add_rectangle(size, size)
                        : kind == 1 ? builder.add_solid(Sphere{size + by})
                                    : builder.add_mesh(plate().transformed(size, Vec3(0.0)).build(), "auto");
      list.push_back({object, translate(centre + along * normal) * turn});
    };
    put(0.0, 0.0);
    if (with_second) put(kind == 1 ? 0.0 : gap, gap);
    (with_second ? out.both : out.first) = scene_of(builder, list);
  }
  return out;
}

double skips_what_is_near(Random& random, const Gap& gap) {
  const Vec3 way = direction_from(gap.normal, uniform(random, 0.05, 1), random);
  const Vec3 target = gap.centre + 0.2 * gap.size * glm::cross(gap.normal, random_direction(random));
  const Ray ray{target - 3.0 * gap.size * way, way};
  Hit hit = closest(*gap.first, ray);
  if (!hit.found()) return 0.0;
  const Surface surface = resolve(*gap.first, ray, hit);
  const bool ball = gap.first->objects[0].kind == Kind::Solid;
  const Vec3 out = ball ? direction_from(surface.normal, uniform(random, 0.05, 1), random) : way;
  const Hit next = closest(*gap.both, {surface.spawn(out), out});
  return !next.found() || next.primitive < gap.first->objects[gap.first->root].primitives;
}

// --- Gate 11: a floor, a light above it and, at times, a blocker 64 u of the light's position in front of the light.

struct Lit {
  std::shared_ptr<const Scene> open, blocked;
  double size;
};

Lit random_light(Random& random) {
  const int kind = random() % 4;
  const double size = power_of_ten(random, -8, 8), light_size = size * power_of_ten(random, -4, -0.5);
  const Affine all = rotate(uniform(random, 0, 6), random_direction(random));
  const Vec3 middle(uniform(random, -0.5, 0.5) * size, size * uniform(random, 0.5, 2), uniform(random, -0.5, 0.5) * size);
  const Affine down = rotate(kPi + uniform(random, -1, 1), glm::normalize(Vec3(1, 0, uniform(random, -1, 1))));
  Lit out{nullptr, nullptr, size};
  for (bool blocked : {false, true}) {
    SceneBuilder builder;
    const int lamp = builder.add_material({.reflectance = Rgb(0.0), .emission = Rgb(1.0)});
    std::vector<InstanceSource> list{{builder.add_rectangle(4 * size, 4 * size), all}};
    const Affine place = all * translate(middle) * down;
    const Vec3 normal = place.vector(Vec3(0, 1, 0));
    double gap = 64 * kUnitRoundoff * (max_abs(place.offset) + light_size);
    if (kind == 2) gap += 64 * 0x1p-24 * light_size;
    uint32_t light, blocker;
    switch (kind) {
      case 0:
        light = builder.add_rectangle(light_size, light_size);
        blocker = builder.add_rectangle(2 * light_size, 2 * light_size);
        break;
      case 1:
        light = builder.add_flat(Disk{0.5 * light_size});
        blocker = builder.add_flat(Disk{light_size});
        break;
      case 2:
        light = builder.add_mesh(plate().transformed(light_size, Vec3(0.0)).build(), "auto");
        blocker = builder.add_rectangle(2 * light_size, 2 * light_size);
        break;
      default:
        light = builder.add_solid(Sphere{0.5 * light_size});
        blocker = builder.add_solid(Sphere{0.5 * light_size + gap});
    }
    list.push_back({light, place, lamp});
    if (blocked) list.push_back({blocker, kind == 3 ? place : translate(gap * normal) * place});
    (blocked ? out.blocked : out.open) = scene_of(builder, list);
  }
  return out;
}

double wrong_shadows(Random& random, const Lit& lit) {
  const Scene& scene = *lit.open;
  const AreaLight& light = scene.lights.areas.at(0);
  const Affine& floor = scene.groups[scene.objects[scene.root].index].instances[0].to_parent;
  const Vec3 up = floor.vector(Vec3(0, 1, 0));
  const Vec3 target = floor.point(lit.size * Vec3(uniform(random, -1, 1), 0.0, uniform(random, -1, 1)));
  const Vec3 way = direction_from(-up, uniform(random, 0.1, 1), random);
  const Ray ray{target - 0.2 * lit.size * way, way};
  const Hit hit = closest(scene, ray);
  if (hit.primitive != 0) return 0.0;  // the light stood in the way
  const Surface surface = resolve(scene, ray, hit);
  Sampler sampler(static_cast<uint32_t>(random()), static_cast<uint32_t>(random()), static_cast<uint32_t>(random()), 0);
  const DirectLight direct = sample_direct(scene, surface, {0, 1.0}, sampler);
  // Seen along its plane a flat light has no front: what is left of it there weighs nothing.
  if (!direct.arrives() || glm::dot(direct.direction, surface.normal) < 1e-4) return 0.0;
  if (light.shape != AreaLight::Shape::Ball) {
    const Vec3 normal = light.flip * glm::normalize(glm::cross(light.pieces[0].edge1, light.pieces[0].edge2));
    if (-glm::dot(direct.direction, normal) < 1e-3) return 0.0;
  }
  return occluded(scene, direct.shadow) + !occluded(*lit.blocked, direct.shadow);
}

}  // namespace

void add_spawned_rays(std::vector<Case>& out) {
  out.push_back({"spawned-rays", 9, "rays that meet the surface that they leave", 0, Combine::Sum, 1'000'000, 1'000'000'000,
                 over_scenes(random_body, meets_itself)});
  out.push_back({"spawned-into-a-gap", 10, "surfaces 64 u away that are skipped", 0, Combine::Sum, 1'000'000, 1'000'000'000,
                 over_scenes(random_gap, skips_what_is_near)});
  out.push_back({"shadow-rays", 11, "shadow rays that meet their light, or miss a blocker 64 u in front of it", 0, Combine::Sum,
                 1'000'000, 1'000'000'000, over_scenes(random_light, wrong_shadows)});
}

}  // namespace tilecast::stress
