// Paths through a plain scene, four at a time: what trace_path (path.cpp) gives, bit for bit.
//
// Paths go on segment by segment, all of a batch together, and those that have ended are closed up behind (wavefront path
// tracing: Laine, Karras and Aila, "Megakernels Considered Harmful", HPG 2013). Where all is chalk, all of them take the same
// random numbers at one depth, so that nothing but the points' keys tells them apart.
#pragma once

#include "base/sampler_lanes.h"
#include "integrators/integrator.h"
#include "scene/plain_scene.h"

namespace tilecast {

class PlainPaths {
 public:
  static constexpr uint32_t kSize = 512;  // paths of a batch

  PlainPaths(const Scene& scene, const PlainScene& plain);

  bool full() const { return count_ == kSize; }
  uint32_t count() const { return count_; }
  // A path along a camera ray, for which numbers have been taken from the sampler. One sampler gives them for all paths
  // up to the same dimension.
  void add(const Ray& ray, const Sampler& sampler, Seen seen);
  // The same through a pixel, by a sampler that nothing has been taken from. For pinholes with the box as filter, and then
  // for all paths.
  void add(uint32_t x, uint32_t y, const Sampler& sampler, Seen seen);
  // Traces all; then they are forgotten, but for what they bring.
  void trace(Tracing& tracing);
  // Of the path that was added as number i.
  const Rgb& radiance(uint32_t i) const { return radiance_[i]; }

 private:
  template <bool kChalk>
  uint32_t segment(uint32_t first, uint32_t to, uint32_t live, Tracing& tracing);
  void leave(uint32_t first, uint32_t seldom, Tracing& tracing);
  void start(const Sampler& sampler, Seen seen);
  void aim();
  SamplerLanes<Uint4> sampler_of(uint32_t first) const;
  void end(uint32_t first, uint32_t ended, const Vec3x4& sum);

  const Scene& scene_;
  const PlainScene& plain_;
  const int max_depth_;
  uint32_t count_ = 0, dimension_ = 0;
  int depth_ = 1;
  bool by_pixels_ = false;  // the places of the origins hold those of pixels
  // Of the paths that have not ended; each array has room for four more, which are written and not read.
  struct alignas(32) Lane {
    double at[kSize + kDoubles];
  };
  Lane origin_[3], direction_[3], throughput_[3], sum_[3], bsdf_pdf_;
  struct alignas(16) Number {
    uint32_t at[kSize + kDoubles];
  };
  Number key_, index_, path_;
  // Where not all is chalk: PathState::scale, whether it is inside of the glass, and how many numbers it has taken.
  Lane scale_;
  Number inside_, taken_;
  bool apart_[kSize + kDoubles];  // at the first segment
  Rgb radiance_[kSize];
};

}  // namespace tilecast
