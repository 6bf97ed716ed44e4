// Gates 1 and 2: rays at the vertices and edges of closed meshes.
#include <memory>
#include <random>

#include "accel/accelerated_mesh.h"
#include "stress/meshes.h"
#include "stress/stress.h"

namespace tilecast::stress {
namespace {

// Closed meshes at scales 1e-6 .. 1e6 and offsets of 0 .. 1e6 radii.
struct Placed {
  AcceleratedMesh mesh;
  Vec3 inside;      // a point well within
  double radius;    // of a ball about it that is within, too
};

const std::vector<Placed>& placed_meshes() {
  static const std::vector<Placed> all = [] {
    struct Source {
      MeshSource mesh;
      Vec3 inside;
      double radius;
    } sources[] = {{icosphere(3), Vec3(0.0), 0.9},
                   {gridded_cube(6), Vec3(0.0), 0.9},
                   {torus(1.0, 0.4, 30, 20), Vec3(1.0, 0.0, 0.0), 0.3}};
    std::mt19937_64 random(1);
    std::vector<Placed> out;
    for (double scale : {1e-6, 1.0, 1e6})
      for (double radii : {0.0, 1.0, 1e3, 1e6})
        for (const Source& s : sources) {
          Vec3 offset = radii * scale * random_direction(random);
          out.push_back({AcceleratedMesh(s.mesh.transformed(scale, offset).build(), "auto"), offset + scale * s.inside,
                         scale * s.radius});
        }
    return out;
  }();
  return all;
}

enum class Count { Leaks, Unbalanced };

double aim(uint64_t first, uint64_t count, Count what) {
  std::mt19937_64 random(first);
  std::uniform_real_distribution<double> unit(0, 1);
  double failures = 0;
  for (uint64_t i = first; i < first + count; ++i) {
    const Placed& placed = placed_meshes()[i % placed_meshes().size()];
    Vec3 target = vertex_or_edge_point(placed.mesh.mesh(), random);
    bool from_inside = i & 1;
    double distance = from_inside ? placed.radius * unit(random) : 100.0 * placed.radius;
    Ray ray{placed.inside + distance * random_direction(random), {}};
    ray.direction = target - ray.origin;
    if (i & 2) ray.direction = glm::normalize(ray.direction);
    int entries = 0, exits = 0;
    bool hit = false;
    placed.mesh.intersect(ray, -kInfinity, kInfinity, [&](uint32_t, const TriangleHit& h) {
      (h.entering ? entries : exits) += 1;
      hit |= h.t > 0.0;
      return false;
    });
    failures += what == Count::Leaks ? (from_inside && !hit) : entries != exits;
  }
  return failures;
}

}  // namespace

void add_triangles(std::vector<Case>& out) {
  out.push_back({"watertight", 1, "rays that leave a closed mesh", 0, Combine::Sum, 1'000'000, 1'000'000'000,
                 [](uint64_t first, uint64_t count) { return aim(first, count, Count::Leaks); }});
  out.push_back({"even-crossings", 2, "lines whose signed crossings do not sum to zero", 0, Combine::Sum, 1'000'000,
                 1'000'000'000, [](uint64_t first, uint64_t count) { return aim(first, count, Count::Unbalanced); }});
}

}  // namespace tilecast::stress
