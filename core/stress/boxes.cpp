// Gates 3 and 4: box tests. Whatever brute force hits, every accelerator hits.
#include <array>

#include "stress/scenes.h"
#include "stress/stress.h"

namespace tilecast::stress {
namespace {

// --- Gate 3: a cube and blocks, of faces on a lattice of quarters.

std::shared_ptr<const Scene> on_quarters(std::string_view kind) {
  SceneBuilder builder;
  uint32_t cube = builder.add_mesh(gridded_cube(2).build(), kind), block = builder.add_solid(Block{Vec3(-0.25), Vec3(0.25)});
  std::vector<InstanceSource> instances{{cube, Affine{}}};
  for (int i = 0; i < 8; ++i) instances.push_back({block, translate(0.5 * Vec3(i % 2, i / 2 % 2, i / 4))});
  return scene_of(builder, instances, kind);
}

// All directions whose components are negative, -0, 0 or positive: the 27 patterns of signs and zeros, with both zeros.
std::vector<Vec3> direction_patterns() {
  std::vector<Vec3> out;
  const double values[] = {-1.0, -0.0, 0.0, 1.0};
  for (double x : values)
    for (double y : values)
      for (double z : values)
        if (x != 0.0 || y != 0.0 || z != 0.0) out.push_back({x, y, z});
  return out;
}

const Scenes& scenes_on_quarters() {
  static const Scenes all = for_each_kind(on_quarters);
  return all;
}

Ray axis_ray(Random& random, uint64_t i) {
  static const std::vector<Vec3> patterns = direction_patterns();
  std::uniform_real_distribution<double> unit(0, 1);
  Ray ray{{}, patterns[i % patterns.size()]};
  for (int k = 0; k < 3; ++k) {
    // On a plane of faces, or anywhere; the sign of zero both ways.
    ray.origin[k] = random() & 1 ? 0.25 * (static_cast<int>(random() % 11) - 5) : 3.0 * unit(random) - 1.5;
    if (random() & 1) ray.origin[k] = -ray.origin[k];
    if (random() & 1) ray.direction[k] *= 0.25 + unit(random);
  }
  return ray;
}

// --- Gate 4: rays at vertices, edges and box corners, at scales 1e-6 .. 1e6 and offsets of up to 1e6 radii.

struct Target {
  Scenes scenes;
  Vec3 centre;
  double radius;
};

template <bool kAlongAxes>
const std::vector<Target>& targets() {
  static const std::vector<Target> all = [] {
    Random random(4);
    std::vector<Target> out;
    for (double size : {1e-6, 1.0, 1e6})
      for (double radii : {0.0, 1e3, 1e6}) {
        Vec3 offset = radii * size * random_direction(random);
        for (const MeshSource& mesh : {icosphere(kAlongAxes ? 3 : 1), gridded_cube(3),
                                       kAlongAxes ? torus(1.0, 0.4, 6, 4) : torus(0.8, 0.3, 8, 6)})
          out.push_back({for_each_kind([&](std::string_view kind) {
                           SceneBuilder builder;
                           uint32_t object = builder.add_mesh(mesh.transformed(size, offset).build(), kind);
                           return builder.build(object, {});
                         }), offset, size});
        std::vector<InstanceSource> blocks;
        for (int i = 0; i < 40; ++i) blocks.push_back({0, translate(offset) * scale(Vec3(size)) * random_affine(random)});
        out.push_back({for_each_kind([&](std::string_view kind) {
                         SceneBuilder builder;
                         builder.add_solid(Block{Vec3(-0.25), Vec3(0.25)});
                         return scene_of(builder, blocks, kind);
                       }), offset, size});
      }
    return out;
  }();
  return all;
}

// A point where boxes are tightest: a vertex or an edge of a mesh, a corner or an edge of a block.
Vec3 tight_point(const Scene& scene, Random& random) {
  if (!scene.meshes.empty()) return vertex_or_edge_point(scene.meshes[0].mesh(), random);
  const auto& blocks = scene.groups[0].instances;
  uint64_t bits = random();
  Vec3 corner{bits & 1 ? 0.25 : -0.25, bits & 2 ? 0.25 : -0.25, bits & 4 ? 0.25 : -0.25};
  if (bits & 8) corner[(bits >> 4) % 3] *= std::uniform_real_distribution<double>(-1, 1)(random);
  return blocks[(bits >> 8) % blocks.size()].to_parent.point(corner);
}

// Each ray is tried on every accelerator; brute force is asked once. Along an axis, a ray stays on the planes that boxes and
// cells end at.
template <bool kAlongAxes>
double culled(uint64_t first, uint64_t count) {
  const uint64_t others = targets<kAlongAxes>()[0].scenes.size() - 1;
  thread_local std::vector<Crossing> expected, found;
  const Target* target = nullptr;
  Ray ray;
  return sum_over_rows(first, count, others, [&](Random& random, uint64_t number) {
    target = &targets<kAlongAxes>()[number % targets<kAlongAxes>().size()];
    const Vec3 point = tight_point(*target->scenes[0], random);
    const double distance = (random() & 1 ? 0.5 : 30.0) * target->radius;
    if constexpr (kAlongAxes) {
      ray = {point, Vec3(0.0)};
      const int axis = random() % 3;
      ray.direction[axis] = random() & 1 ? 1.0 : -1.0;
      ray.origin[axis] -= distance * ray.direction[axis];
    } else {
      const Vec3 origin = target->centre + distance * random_direction(random);
      ray = {origin, point - origin};
    }
    crossings(*target->scenes[0], ray, expected);
  }, [&](Random&, uint64_t i) {
    crossings(*target->scenes[1 + i % others], ray, found);
    return std::count_if(expected.begin(), expected.end(), [&](const Crossing& e) {
      return std::none_of(found.begin(), found.end(), [&](const Crossing& f) { return f.t == e.t && f.primitive == e.primitive; });
    });
  });
}

}  // namespace

void add_boxes(std::vector<Case>& out) {
  out.push_back({"zeros-in-directions", 3, "rays that differ from brute force", 0, Combine::Sum, 1'000'000, 1'000'000'000,
                 against_brute_force(scenes_on_quarters, axis_ray)});
  out.push_back({"culled", 4, "hits of brute force that are lost", 0, Combine::Sum, 1'000'000, 1'000'000'000,
                 culled<false>});
  out.push_back({"along-axes", 4, "hits of brute force that are lost, along an axis", 0, Combine::Sum, 1'000'000, 1'000'000'000,
                 culled<true>});
}

}  // namespace tilecast::stress
