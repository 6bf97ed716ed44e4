// Gates 1, 2 and 8: rays at the vertices and edges of closed meshes, also of such with collinear faces; and gate 5 for rays
// that are traced together.
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

// Rays that are traced together: at edges of one face or of its neighbours, from one point or from near it, or all over.
struct Batch {
  static constexpr uint64_t kRays = 64;
  const Placed* placed;
  bool from_inside;
  std::array<Ray, kRays> rays;
  std::array<FaceHit, kRays> closest;
  std::array<uint32_t, kRays> stopped_by;

  void trace(Random& random, uint64_t number) {
    const auto& meshes = plain_meshes();
    placed = &meshes[number % meshes.size()];
    const uint64_t round = number / meshes.size();
    from_inside = round & 1;
    const Mesh& mesh = placed->mesh.mesh();
    const size_t face = random() % mesh.faces.size(), neighbours = std::array<size_t, 4>{1, 8, 64, mesh.faces.size()}[round / 2 % 4];
    const double apart = placed->radius * std::array{0.0, 1e-3, 0.05, 0.4}[round / 8 % 4];
    const Vec3 eye = placed->inside + placed->radius * (from_inside ? uniform(random, 0.0, 0.5) : 4.0) * random_direction(random);
    for (Ray& ray : rays) {
      ray = {eye + apart * random_direction(random), {}};
      ray.direction = vertex_or_edge_point(mesh, (face + random() % neighbours) % mesh.faces.size(), random) - ray.origin;
      if (round / 32 % 2) ray.t_max = 1.0;
    }
    placed->mesh.closest(rays, closest.data());
    placed->mesh.occluded(rays, stopped_by.data());
  }
  // Whether a ray of the batch leaves the mesh, or alone has another answer.
  bool fails(size_t i) const {
    NoCost free;
    const FaceHit &hit = closest[i], alone = placed->mesh.closest(rays[i], free);
    const bool found = alone.face != FaceHit::kNone;
    return (from_inside && rays[i].t_max == kInfinity && !found) || (stopped_by[i] != FaceHit::kNone) != found || hit.face != alone.face ||
           (found && (hit.t != alone.t || hit.u != alone.u || hit.v != alone.v || hit.entering != alone.entering));
  }
};

double failing_in_batches(uint64_t first, uint64_t count) {
  thread_local Batch batch;
  return sum_over_rows(first, count, Batch::kRays, [](Random& random, uint64_t number) { batch.trace(random, number); },
                       [](Random&, uint64_t i) { return batch.fails(i % Batch::kRays); });
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
  out.push_back({"batches", 5, "rays that leave a closed mesh, or have another answer together than alone", 0, Combine::Sum,
                 1'000'000, 1'000'000'000, failing_in_batches});
}

}  // namespace tilecast::stress
