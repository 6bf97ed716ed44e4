// Gates 5 and 6: every accelerator gives the answer of brute force, bit for bit, ties and lattices included.
#include "stress/scenes.h"
#include "stress/stress.h"

namespace tilecast::stress {
namespace {

bool tie_differs(std::mt19937_64& random, uint64_t i) {
  static const std::vector<std::shared_ptr<const Scene>> scenes = for_each_kind([](std::string_view kind) {
    return crowd({.seed = 5, .cells = 1, .levels = 0, .copies = 2, .groups = 3}, kind);
  });
  Ray ray = random_ray(random, i % 2 ? 0.5 : 8.0);
  if (i % 7 == 0) ray.direction[i % 3] = 0.0;
  return !same_hits(*scenes[0], *scenes[1 + i % (scenes.size() - 1)], ray);
}

// A mesh and blocks whose corners lie on a lattice of eighths.
std::shared_ptr<const Scene> lattice(std::string_view kind) {
  std::mt19937_64 random(6);
  SceneBuilder builder;
  uint32_t cube = builder.add_mesh(gridded_cube(2).build(), kind), block = builder.add_solid(Block{Vec3(0.0), Vec3(0.25)});
  std::vector<InstanceSource> instances{{cube, Affine{}}};
  for (int i = 0; i < 16; ++i)
    instances.push_back({block, translate(0.25 * Vec3(int(random() % 8) - 4, int(random() % 8) - 4, int(random() % 8) - 4))});
  return scene_of(builder, instances, kind);
}

// From a point of the lattice to another, past corners and along edges of cells.
bool lattice_ray_differs(std::mt19937_64& random, uint64_t i) {
  static const std::vector<std::shared_ptr<const Scene>> scenes = for_each_kind(lattice);
  auto point = [&] {
    Vec3 p;
    for (int k = 0; k < 3; ++k) p[k] = 0.125 * (static_cast<int>(random() % 25) - 12);
    return p;
  };
  Ray ray{point(), {}};
  do ray.direction = point() - ray.origin;
  while (ray.direction == Vec3(0.0));
  if (i & 1) {  // along an axis
    int axis = i / 2 % 3;
    ray.direction = Vec3(0.0);
    ray.direction[axis] = i / 6 % 2 ? 1.0 : -1.0;
  }
  return !same_hits(*scenes[0], *scenes[1 + i / 12 % (scenes.size() - 1)], ray);
}

}  // namespace

void add_agreement(std::vector<Case>& out) {
  out.push_back({"ties", 5, "rays that differ from brute force", 0, Combine::Sum, 100'000, 1'000'000'000,
                 sum_of(tie_differs)});
  out.push_back({"lattice", 6, "rays that differ from brute force", 0, Combine::Sum, 500'000, 100'000'000,
                 sum_of(lattice_ray_differs)});
}

}  // namespace tilecast::stress
