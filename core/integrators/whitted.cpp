#include "integrators/whitted_branch.h"

namespace tilecast {
namespace {

template <bool kPassable>
Rgb trace(const Scene& scene, const Ray& camera_ray, const MediaOf<kPassable>& camera_media, Sampler& sampler,
          Tracing& tracing) {
  thread_local std::vector<Branch<kPassable>> kept;  // from ray to ray, so that tracing does not allocate
  std::vector<Branch<kPassable>>& pending = kept;
  pending.clear();
  pending.push_back({camera_ray, Rgb(1.0), camera_media, 1});
  ++tracing.counts.camera;
  Rgb sum(0.0);
  while (!pending.empty()) {
    Branch<kPassable> branch = pending.back();
    pending.pop_back();
    shade<kPassable>(
        scene, branch, closest(scene, branch.ray), sampler, sum, tracing,
        [&](const Hit& hit) { return resolve(scene, branch.ray, hit); },
        [&](const Branch<kPassable>& next) -> Branch<kPassable>& { return pending.emplace_back(next); },
        [&](const Rgb& weight, const Ray& ray, const MediaOf<kPassable>& media, size_t light, Glass glass) {
          sum += weight * unshadowed(scene, ray, media, glass, light, tracing);
        });
  }
  return sum;
}

}  // namespace

Rgb trace_whitted(const Scene& scene, const Ray& ray, const Media& media, Sampler& sampler, Tracing& tracing) {
  if (passable(scene)) return trace<true>(scene, ray, media, sampler, tracing);
  return trace<false>(scene, ray, {}, sampler, tracing);
}

}  // namespace tilecast
