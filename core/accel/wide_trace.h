// Rays through a WideBvh, by vectors of eight floats; the instruction set is chosen when the program runs. What is hit,
// and where, is bit for bit what geometry/triangle.h answers.
#pragma once

#include <span>

#include "accel/wide_bvh.h"
#include "base/ray.h"

namespace tilecast {

struct FaceHit {
  static constexpr uint32_t kNone = ~0u;

  double t = kInfinity;
  double u = 0.0, v = 0.0;  // weights of the second and third vertex
  uint32_t face = kNone;
  bool entering = false;
};

// For each ray the first of its hits in t_min < t <= t_max, ordered by (t, face). Neighbouring rays that are alike go
// together; large batches of unlike rays are traced in an order of their own.
void closest(const WideBvh& bvh, const Frame& frame, std::span<const Ray> rays, FaceHit* hits);
FaceHit closest(const WideBvh& bvh, const Frame& frame, const Ray& ray);
FaceHit closest(const WideBvh& bvh, const Frame& frame, const Ray& ray, TraversalCost& cost);

// For each ray a face hit in t_min < t <= t_max, or FaceHit::kNone.
void occluded(const WideBvh& bvh, const Frame& frame, std::span<const Ray> rays, uint32_t* faces);
uint32_t occluded(const WideBvh& bvh, const Frame& frame, const Ray& ray);

// Appends the hits in t_min < t <= t_max in no order; twice what stands in two blocks.
void all_hits(const WideBvh& bvh, const Frame& frame, const Ray& ray, std::vector<FaceHit>& hits);

}  // namespace tilecast
