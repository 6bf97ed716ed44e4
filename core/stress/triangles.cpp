// Gates 1, 2 and 8: rays at the vertices and edges of closed meshes, also of such with collinear faces.
#include "accel/accelerated_mesh.h"
#include "stress/meshes.h"
#include "stress/stress.h"

namespace tilecast::stress {
namespace {

struct Placed {
  AcceleratedMesh mesh;
  Vec3 inside;      // a point well within
  double radius;    // of a ball about it that is within, too
};

// Closed meshes at scales 1e-6 .. 1e6 and offsets of 0 .. 1e6 radii.
std::vector<Placed> place(MeshSource (*change)(const MeshSource&)) {
  struct Source {
    MeshSource mesh;
    Vec3 inside;
    double radius;
  } sources[] = {{icosphere(3), Vec3(0.0), 0.9},
                 {gridded_cube(6), Vec3(0.0), 0.9},
                 {torus(1.0, 0.4, 30, 20), Vec3(1.0, 0.0, 0.0), 0.3}};
  Random random(1);
  std::vector<Placed> out;
  for (double scale : {1e-6, 1.0, 1e6})
    for (double radii : {0.0, 1.0, 1e3, 1e6})
      for (const Source& s : sources) {
        Vec3 offset = radii * scale * random_direction(random);
        out.push_back({AcceleratedMesh(change(s.mesh).transformed(scale, offset).build(), "bvh"),
                       offset + scale * s.inside, scale * s.radius});
      }
  return out;
}

const std::vector<Placed>& plain_meshes() {
  static const std::vector<Placed> all = place([](const MeshSource& m) { return m; });
  return all;
}
const std::vector<Placed>& collinear_meshes() {
  static const std::vector<Placed> all = place(with_collinear_faces);
  return all;
}

struct Tally {
  bool leaks = false;  // from inside, and nothing is hit
  bool unbalanced = false;
};

Tally aim(const std::vector<Placed>& meshes, Random& random, uint64_t i) {
  std::uniform_real_distribution<double> unit(0, 1);
  const Placed& placed = meshes[i % meshes.size()];
  uint64_t round = i / meshes.size();
  bool from_inside = round & 1;
  Vec3 target = vertex_or_edge_point(placed.mesh.mesh(), random);
  double distance = from_inside ? placed.radius * unit(random) : 100.0 * placed.radius;
  Ray ray{placed.inside + distance * random_direction(random), {}, -kInfinity};
  ray.direction = target - ray.origin;
  if (round & 2) ray.direction = glm::normalize(ray.direction);
  int sum = 0;
  bool hit = false;
  thread_local std::vector<FaceHit> hits;
  hits.clear();
  placed.mesh.all_hits(ray, hits);
  for (const FaceHit& h : hits) {
    sum += h.entering ? 1 : -1;
    hit |= h.t > 0.0;
  }
  return {from_inside && !hit, sum != 0};
}

}  // namespace

void add_triangles(std::vector<Case>& out) {
  out.push_back({"watertight", 1, "rays that leave a closed mesh", 0, Combine::Sum, 1'000'000, 1'000'000'000,
                 sum_of([](auto& random, uint64_t i) { return aim(plain_meshes(), random, i).leaks; })});
  out.push_back({"even-crossings", 2, "lines whose signed crossings do not sum to zero", 0, Combine::Sum, 1'000'000,
                 1'000'000'000,
                 sum_of([](auto& random, uint64_t i) { return aim(plain_meshes(), random, i).unbalanced; })});
  out.push_back({"collinear-faces", 8, "leaks and unbalanced lines, 10% of the faces collinear", 0, Combine::Sum, 1'000'000,
                 1'000'000'000, sum_of([](auto& random, uint64_t i) {
                   Tally tally = aim(collinear_meshes(), random, i);
                   return tally.leaks || tally.unbalanced;
                 })});
}

}  // namespace tilecast::stress
