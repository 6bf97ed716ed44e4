// The samples of pixels, one at a time: what all faster ways must agree with, bit for bit.
#pragma once

#include "base/error.h"
#include "render/camera_sample.h"
#include "render/lamps_in_view.h"

namespace tilecast {

// Whether parallel camera rays all start outside of what the scene's objects fill.
inline bool start_outside(const Scene& scene) {
  const Camera& camera = scene.camera;
  const double reach = PixelFilter::radius(scene.filter.kind());  // of a pixel's samples, from its middle
  Box origins;
  for (double x : {-reach, camera.width() + reach})
    for (double y : {-reach, camera.height() + reach}) origins.extend(camera.ray(x, y).origin);
  const Box& all = scene.objects[scene.root].bounds;
  return glm::any(glm::lessThan(origins.hi, all.lo)) || glm::any(glm::greaterThan(origins.lo, all.hi));
}

class Samples {
 public:
  explicit Samples(const Scene& scene) : scene_(scene), media_(media_at(scene, scene.camera.position())), lamps_(scene) {}

  const Scene& scene() const { return scene_; }
  RayCounts& rays() { return tracing_.counts; }
  Tracing& tracing() { return tracing_; }

  // What is around a camera ray's origin.
  Media media(const Ray& ray) const { return many_medias_ ? media_at(scene_, ray.origin) : media_; }

  // Whether that may differ from ray to ray.
  bool many_medias() const { return many_medias_; }

  // Whether all camera rays start outside of all dielectrics, for sure.
  bool in_vacuum() const { return in_vacuum_; }

  // Whether the pixel's samples look for lamps apart.
  bool looks_for_lamps(int x, int y) const { return in_vacuum_ && lamps_.at(x, y); }

  // Radiance, weighed by the filter.
  Rgb take(uint32_t x, uint32_t y, uint32_t sample, bool lamps) {
    double weight;
    const Rgb value = take(x, y, sample, weight, lamps ? Seen::Apart : Seen::ByPath);
    return lamps ? weight * value + look(x, y, sample) : weight * value;
  }

  // Radiance, and what the filter weighs it by.
  Rgb take(uint32_t x, uint32_t y, uint32_t sample, double& weight, Seen seen = Seen::ByPath) {
    Sampler sampler(x, y, sample, scene_.seed, scene_.sampling);
    const CameraSample at = sample_camera(scene_, x, y, sampler);
    const Rgb value = many_medias_ ? radiance(scene_, at.ray, media_at(scene_, at.ray.origin), sampler, tracing_, seen)
                                    : radiance(scene_, at.ray, media_, sampler, tracing_, seen);
    weight = at.weight;
    check(weight * value, x, y, sample);
    return value;
  }

  // The part of a sample that looks for lamps apart from its path.
  Rgb look(uint32_t x, uint32_t y, uint32_t sample) { return LampsInView::look(scene_, x, y, sample, tracing_); }

  void check(const Rgb& value, uint32_t x, uint32_t y, uint32_t sample) const {
    if (!is_finite(value))
      throw SampleError("a sample is not finite: pixel (" + std::to_string(x) + ", " + std::to_string(y) + "), sample " +
                        std::to_string(sample) + ", seed " + std::to_string(scene_.seed));
  }

 private:
  const Scene& scene_;
  const Media media_;  // at the camera
  LampsInView lamps_;
  const bool many_medias_ = built_with("dielectric") && scene_.camera.has_extent() && scene_.dielectrics;
  const bool in_vacuum_ = media_.empty() && (!many_medias_ || start_outside(scene_));
  Tracing tracing_;
};

}  // namespace tilecast
