// Gates 33 and 34: builders that cannot split, and hierarchies that want to be a chain.
#include "stress/scenes.h"
#include "stress/stress.h"

namespace tilecast::stress {
namespace {

// `count` small triangles, at random places or all at one.
AcceleratedMesh small_triangles(uint64_t count, bool identical, std::string_view kind) {
  Random random(33);
  std::uniform_real_distribution<double> unit(-1, 1);
  MeshSource source;
  Vec3 place(0.0);
  for (uint32_t i = 0; i < count; ++i) {
    if (i == 0 || !identical) {
      place = {unit(random), unit(random), unit(random)};
      uint32_t first = static_cast<uint32_t>(source.vertices.size());
      source.vertices.insert(source.vertices.end(), {place, place + Vec3(0.01, 0, 0), place + Vec3(0, 0.01, 0)});
      source.faces.push_back({first, first + 1, first + 2});
    } else {
      source.faces.push_back({0, 1, 2});
    }
  }
  return AcceleratedMesh(source.build(), kind);
}

// Bytes under the worst accelerator over those of as many distinct triangles; infinity where one is not hit.
double memory_of_identical(uint64_t count) {
  double worst = 0.0;
  for (const std::string& kind : accelerator_kinds()) {
    uint64_t distinct = small_triangles(count, false, kind).bytes();
    AcceleratedMesh mesh = small_triangles(count, true, kind);
    worst = std::max(worst, static_cast<double>(mesh.bytes()) / distinct);
    Vec3 corner = mesh.mesh().frame.from_frame(Vec3(mesh.mesh().vertices[0]));
    std::vector<bool> seen(count);
    for (const FaceHit& hit : mesh.all_hits({corner + Vec3(0.002, 0.003, 1.0), Vec3(0, 0, -1)})) seen[hit.face] = true;
    if (!std::all_of(seen.begin(), seen.end(), [](bool s) { return s; })) return kInfinity;
  }
  return worst;
}

// Each primitive 1.002 times as large as the one before, and as far away: a heuristic cuts off one at a time.
std::shared_ptr<const Scene> chain(std::string_view kind) {
  MeshSource source;
  double size = 1.0;
  for (uint32_t i = 0; i < 10'000; ++i, size *= 1.002) {
    source.vertices.insert(source.vertices.end(), {Vec3(size, 0, 0), Vec3(size, size, 0), Vec3(size, 0, size)});
    source.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  SceneBuilder builder;
  uint32_t mesh = builder.add_mesh(source.build(), kind);
  return builder.build(mesh, {});
}

const Scenes& chains() {
  static const Scenes all = for_each_kind(chain);
  return all;
}

Ray chain_ray(Random& random, uint64_t) {
  std::uniform_real_distribution<double> unit(0, 1);
  double size = std::pow(1.002, 10'000 * unit(random));
  Vec3 target = size * Vec3(1.0, 0.5 * unit(random), 0.5 * unit(random));
  Ray ray{target + size * (random() & 1 ? random_direction(random) : Vec3(-unit(random), 0, 0)), {}};
  ray.direction = target - ray.origin;
  return ray;
}

}  // namespace

void add_crowding(std::vector<Case>& out) {
  out.push_back({"identical-primitives", 33, "memory, in that of distinct ones", 2, Combine::Max, 30'000, 10'000'000,
                 [](uint64_t, uint64_t count) { return memory_of_identical(count); }, ~uint64_t(0)});
  out.push_back({"adversarial-chain", 34, "rays that differ from brute force, 10,000 deep", 0, Combine::Sum, 2'000, 1'000'000,
                 against_brute_force(chains, chain_ray), 256});
}

}  // namespace tilecast::stress
