#include "render/first_hits.h"

#include "base/error.h"
#include "render/camera_sample.h"
#include "shading/albedo.h"

namespace tilecast {
namespace {

constexpr double kFarthestSeen = 1e30;  // metres: as much as a light may be bright

}  // namespace

std::vector<float> first_hits(const Scene& scene, const Tile& tile, uint32_t samples) {
  check(tile, scene.camera);
  if (samples < 1) throw Error("there must be at least one sample");
  std::vector<float> out;
  out.reserve(size_t(tile.width) * tile.height * kFirstHitChannels);
  for (int y = tile.y; y < tile.y + tile.height; ++y)
    for (int x = tile.x; x < tile.x + tile.width; ++x) {
      Rgb albedo(0.0);
      Vec3 normal(0.0);
      double distance = 0.0;
      uint32_t hits = 0;
      for (uint32_t sample = 0; sample < samples; ++sample) {
        Sampler sampler(x, y, sample, scene.seed, scene.sampling);
        const auto [ray, weight] = sample_camera(scene, x, y, sampler);
        Hit hit = closest(scene, ray);
        if (!hit.found()) continue;
        Surface surface = resolve(scene, ray, hit);
        albedo += weight * albedo_at(scene, surface, *surface.material);
        normal += weight * surface.normal;
        distance += std::min(hit.t, kFarthestSeen);
        ++hits;
      }
      albedo /= samples;
      normal /= samples;
      distance /= std::max(hits, 1u);
      for (double value : {albedo.x, albedo.y, albedo.z, normal.x, normal.y, normal.z, distance})
        out.push_back(static_cast<float>(value));
    }
  return out;
}

}  // namespace tilecast
