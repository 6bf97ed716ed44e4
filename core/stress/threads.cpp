// Gate 32: a chunk's sums depend on nothing but the chunk. Threads, tiles, their order and the vector width leave no trace.
#include <atomic>
#include <bit>
#include <mutex>
#include <thread>

#include <hwy/highway.h>

#include "render/chunk.h"
#include "stress/scenes.h"
#include "stress/stress.h"

namespace tilecast::stress {
namespace {

constexpr int kWidth = 48, kHeight = 36, kTileSamples = 4;

// Something of everything, so that shared buffers would show.
std::shared_ptr<const Scene> showcase(Integrator integrator, uint32_t seed) {
  Random random(32);
  SceneBuilder builder;
  int glass = builder.add_material({MaterialKind::Dielectric, Rgb(0.8), -1, 0.0, 1.5, Rgb(0.1, 0.2, 0.3)});
  int metal = builder.add_material({MaterialKind::Conductor, Rgb(0.9, 0.7, 0.3), -1, 0.3});
  int checked = builder.add_material({MaterialKind::Diffuse, Rgb(0.8), builder.add_texture(Checker{})});
  int lamp = builder.add_material({MaterialKind::Diffuse, Rgb(0.0), -1, 0.0, 1.5, Rgb(0.0), Rgb(8.0)});
  uint32_t block = builder.add_solid(Block{Vec3(-0.7), Vec3(0.7)}), sphere = builder.add_solid(Sphere{0.9});
  uint32_t drill = builder.add_solid(Cylinder{0.4, 3.0}), floor = builder.add_rectangle(8, 8), panel = builder.add_rectangle(1, 1);
  uint32_t ball = builder.add_mesh(icosphere(2).build(), "auto");
  uint32_t rounded = builder.add_csg(CsgOperation::Intersection, {{block, Affine{}}, {sphere, Affine{}}});
  uint32_t part = builder.add_csg(CsgOperation::Difference, {{rounded, Affine{}}, {drill, Affine{}}});
  builder.add_point_light({Vec3(3, 4, 3), Rgb(20.0)});
  builder.set_background(Rgb(0.2, 0.3, 0.4));
  builder.set_camera(Camera(Vec3(0, 1, 5), Vec3(0), Vec3(0, 1, 0), 50, kWidth, kHeight));
  SceneBuilder::Options options;
  options.integrator = integrator;
  options.seed = seed;
  return scene_of(builder, {{part, translate(Vec3(-1.2, 0, 0)) * random_affine(random), glass},
                            {ball, translate(Vec3(1.2, 0, 0)) * scale(Vec3(0.6)), metal},
                            {sphere, translate(Vec3(0, 0.2, 1.5)) * scale(Vec3(0.3)), glass},
                            {floor, translate(Vec3(0, -1, 0)), checked},
                            {panel, translate(Vec3(0, 3, 0)) * rotate(kPi, Vec3(1, 0, 0)), lamp}}, "auto", options);
}

// The image's sums [2, h, w, 3], tiles of this size shared out among the threads in random order.
std::vector<double> render(const Scene& scene, int threads, int tile, Random& random) {
  std::vector<double> image(2 * kHeight * kWidth * 3);
  std::vector<Tile> tiles;
  for (int y = 0; y < kHeight; y += tile)
    for (int x = 0; x < kWidth; x += tile) tiles.push_back({x, y, std::min(tile, kWidth - x), std::min(tile, kHeight - y)});
  std::shuffle(tiles.begin(), tiles.end(), random);
  std::atomic<size_t> next{0};
  auto work = [&] {
    for (size_t i; (i = next++) < tiles.size();) {
      const Tile& t = tiles[i];
      std::vector<double> sums = render_chunk(scene, t, 0, kTileSamples).sums;
      for (int half = 0; half < 2; ++half)
        for (int row = 0; row < t.height; ++row)
          std::copy_n(&sums[(half * t.height + row) * t.width * 3], t.width * 3,
                      &image[((half * kHeight + t.y + row) * kWidth + t.x) * 3]);
    }
  };
  std::vector<std::jthread> pool;
  for (int i = 1; i < threads; ++i) pool.emplace_back(work);
  work();
  pool.clear();
  return image;
}

// Values that differ in any bit.
double unlike(const std::vector<double>& found, const std::vector<double>& expected) {
  if (found.size() != expected.size()) return kInfinity;
  double out = 0.0;
  for (size_t k = 0; k < found.size(); ++k) out += std::bit_cast<uint64_t>(found[k]) != std::bit_cast<uint64_t>(expected[k]);
  return out;
}

// Values that differ from those of one thread and one tile.
double differing(Random& random, uint64_t i) {
  constexpr int kThreads[] = {1, 2, 7}, kTiles[] = {5, 16, kWidth};
  auto scene = showcase(i % 2 ? Integrator::Whitted : Integrator::Path, static_cast<uint32_t>(i / 18));
  std::vector<double> expected = render_chunk(*scene, {0, 0, kWidth, kHeight}, 0, kTileSamples).sums;
  return unlike(render(*scene, kThreads[i / 2 % 3], kTiles[i / 6 % 3], random), expected);
}

// --- Vector widths: those that the kernels are compiled for and this processor has; the first is used.

constexpr size_t kTracedRays = 512;

// The showcase's sums, and what rays through its mesh meet, one by one and together.
std::vector<double> seen(const Scene& scene, const std::vector<Ray>& rays) {
  std::vector<double> out = render_chunk(scene, {0, 0, kWidth, kHeight}, 0, 1).sums;
  const AcceleratedMesh& mesh = scene.meshes[0];
  auto add = [&](const FaceHit& hit) { out.insert(out.end(), {hit.t, hit.u, hit.v, double(hit.face), double(hit.entering)}); };
  std::vector<FaceHit> hits(rays.size());
  std::vector<uint32_t> faces(rays.size());
  mesh.closest(rays, hits.data());
  mesh.occluded(rays, faces.data());
  std::for_each(hits.begin(), hits.end(), add);
  out.insert(out.end(), faces.begin(), faces.end());
  NoCost free;
  for (const Ray& ray : rays) {
    add(mesh.closest(ray, free));
    out.push_back(mesh.occluded(ray));
    for (const FaceHit& hit : mesh.all_hits(ray)) add(hit);
  }
  return out;
}

double differing_by_width(Random& random, uint64_t i) {
  static std::mutex one;  // the choice is the process's
  std::lock_guard lock(one);
  auto scene = showcase(i % 2 ? Integrator::Whitted : Integrator::Path, static_cast<uint32_t>(i));
  std::vector<Ray> rays(kTracedRays);
  for (size_t k = 0; k < kTracedRays; ++k)  // the first half from one point, side by side: packets
    rays[k] = 2 * k < kTracedRays ? Ray{Vec3(0.3, 0.2, 4), Vec3(-0.9 + 0.11 * (k % 16), -0.9 + 0.11 * (k / 16), -3)} : random_ray(random, 3.0);
  std::vector<double> expected;
  double differ = 0.0;
  for (int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::GetChosenTarget().Update(target);
    std::vector<double> found = seen(*scene, rays);
    if (expected.empty()) expected = found;
    differ += unlike(found, expected);
  }
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  return differ;
}

std::string widths() {
  std::string out;
  for (int64_t target : hwy::SupportedAndGeneratedTargets()) out += (out.empty() ? "" : ", ") + std::string(hwy::TargetName(target));
  return out;
}

}  // namespace

void add_threads(std::vector<Case>& out) {
  out.push_back({"threads-and-tiles", 32, "values that change with threads or tiles", 0, Combine::Sum, 18, 9'000,
                 sum_of(differing), 1});
  out.push_back({"vector-widths", 32, "values that change with the processor's vectors, here " + widths(), 0, Combine::Sum, 18,
                 9'000, sum_of(differing_by_width), 1});
}

}  // namespace tilecast::stress
