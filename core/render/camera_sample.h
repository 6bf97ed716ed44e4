// Where a sample of a pixel goes: the first random numbers of each sample, whatever is then asked along its ray.
#pragma once

#include "base/built.h"
#include "base/sampler.h"
#include "base/square_to_disk.h"
#include "scene/scene.h"

namespace tilecast {

struct CameraSample {
  Ray ray;
  double weight = 1.0;  // of what is seen along it; see PixelFilter
};

inline CameraSample sample_camera(const Scene& scene, uint32_t x, uint32_t y, Sampler& sampler) {
  CameraSample out;
  Vec2 at = sampler.next2();
  if (built_with("pixel_filter")) at = scene.filter.sample(at, out.weight);
  const bool has_lens = scene.camera.has_lens();
  if (has_lens && !built_with("lens")) __builtin_unreachable();
  const Vec2 lens = has_lens ? square_to_disk(sampler.next2()) : Vec2(0.0);
  out.ray = scene.camera.ray(x + at.x, y + at.y, lens);
  return out;
}

// Whether there are lanes for it: of a pinhole, through a box filter.
inline bool has_camera_lanes(const Scene& scene) {
  return scene.camera.is_pinhole() && scene.filter.kind() == PixelFilter::Kind::Box;
}

}  // namespace tilecast
