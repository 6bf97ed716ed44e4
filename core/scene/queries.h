// Ray queries over arrays, for people who want hits and no image.
#pragma once

#include <functional>
#include <span>

#include "scene/surface.h"

namespace tilecast {

struct RaySpan {
  std::span<const Vec3> origins, directions;
  std::span<const double> t_min, t_max;  // one for each ray, or one for all

  size_t size() const { return origins.size(); }
  Ray operator[](size_t i) const {
    return {origins[i], directions[i], t_min[t_min.size() > 1 ? i : 0], t_max[t_max.size() > 1 ? i : 0]};
  }
};

struct HitArrays {
  std::vector<double> t, u, v;             // t: infinity where nothing is hit
  std::vector<int64_t> object, primitive;  // index in the scene's list, number within that object; -1: none
  std::vector<Vec3> normal;                // geometric, outward, unit length; zero where nothing is hit
};

struct CrossingArrays {
  std::vector<int64_t> offsets;  // [n + 1]: ray i owns offsets[i] .. offsets[i + 1]
  std::vector<double> t;
  std::vector<int64_t> object, primitive;
  std::vector<uint8_t> entering;
};

// Called every few hundred rays, so that the caller can end a long list by throwing.
using Pause = std::function<void()>;

HitArrays closest(const Scene& scene, const RaySpan& rays, const Pause& pause);
std::vector<uint8_t> occluded(const Scene& scene, const RaySpan& rays, const Pause& pause);
CrossingArrays crossings(const Scene& scene, const RaySpan& rays, const Pause& pause);  // whole lines, both ways

}  // namespace tilecast
