// Gates 5 and 6: every accelerator gives the answer of brute force, bit for bit, ties and lattices included.
#include "stress/scenes.h"
#include "stress/stress.h"

namespace tilecast::stress {
namespace {

const Scenes& tied_scenes() {
  static const Scenes all = for_each_kind([](std::string_view kind) {
    return crowd({.seed = 5, .cells = 1, .levels = 0, .copies = 1, .groups = 2}, kind);
  });
  return all;
}

Ray tied_ray(Random& random, uint64_t i) {
  Ray ray = random_ray(random, i % 2 ? 0.5 : 8.0);
  if (i % 7 == 0) ray.direction[i % 3] = 0.0;
  return ray;
}

// A mesh and blocks whose corners lie on a lattice of eighths.
std::shared_ptr<const Scene> on_lattice(std::string_view kind) {
  Random random(6);
  SceneBuilder builder;
  uint32_t cube = builder.add_mesh(gridded_cube(2).build(), kind), block = builder.add_solid(Block{Vec3(0.0), Vec3(0.25)});
  std::vector<InstanceSource> instances{{cube, Affine{}}};
  for (int i = 0; i < 16; ++i)
    instances.push_back({block, translate(0.25 * Vec3(int(random() % 8) - 4, int(random() % 8) - 4, int(random() % 8) - 4))});
  return scene_of(builder, instances, kind);
}

// From a point of the lattice to another, past corners and along edges of cells.
Ray lattice_ray(Random& random, uint64_t i) {
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
  return ray;
}

const Scenes& lattice_scenes() {
  static const Scenes all = for_each_kind(on_lattice);
  return all;
}

// A uniform grid whose planes lie on the lattice, or nearly: cubes of a quarter that fill [-1, 1]^3.
Grid lattice_grid() {
  std::vector<FrameBox> boxes;
  for (int i = 0; i < 512; ++i) {
    const Vec3 lo = 0.25 * Vec3(i % 8 - 4, i / 8 % 8 - 4, i / 64 - 4);
    boxes.push_back(FrameBox::around(Frame{}, {lo, lo + 0.25}));
  }
  std::vector<uint32_t> order;
  return Grid::build({boxes}, false, order);
}

// Of a line through it, the cells that it enters over the most that a walk in integers may take, nx + ny + nz + 3.
double steps_taken(Random& random, uint64_t i) {
  static const Grid grid = lattice_grid();
  FrameRay line;
  if (!enter_frame(Frame{}, lattice_ray(random, i), line)) return 0.0;
  TraversalCost cost;
  grid.traverse(line, -FrameBox::kFar, FrameBox::kFar, cost, [](uint32_t, uint32_t) { return false; });
  const int* cells = grid.levels()[0].cells;
  return static_cast<double>(cost.steps) / (cells[0] + cells[1] + cells[2] + 3);
}

}  // namespace

void add_agreement(std::vector<Case>& out) {
  out.push_back({"ties", 5, "rays that differ from brute force", 0, Combine::Sum, 1'000'000, 1'000'000'000,
                 against_brute_force(tied_scenes, tied_ray)});
  out.push_back({"lattice", 6, "rays that differ from brute force", 0, Combine::Sum, 1'000'000, 100'000'000,
                 against_brute_force(lattice_scenes, lattice_ray)});
  out.push_back({"grid-steps", 6, "cells entered on the lattice, in nx + ny + nz + 3", 1, Combine::Max, 1'000'000, 100'000'000,
                 worst_of(steps_taken)});
}

}  // namespace tilecast::stress
