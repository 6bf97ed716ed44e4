// What traversals share: slabs, counters, and a memory of what was tested.
#pragma once

#include "accel/frame_box.h"

namespace tilecast {

// What a ray cost. Traversals take one of these two; the second is free.
struct TraversalCost {
  uint64_t steps = 0;  // nodes and cells entered
  uint64_t tests = 0;  // primitives tested

  void step(uint64_t n = 1) { steps += n; }
  void test(uint64_t n = 1) { tests += n; }
};
struct NoCost {
  void step(uint64_t = 1) {}
  void test(uint64_t = 1) {}
};

inline constexpr float kMissed = std::numeric_limits<float>::infinity();

// Narrows [s_min, s_max] to where the ray is in the box; false where it is not. The reciprocals are finite (see
// base/frame.h), so no product is NaN, and zeros of either sign are like any other direction (compare Williams et al.,
// "An Efficient and Robust Ray-Box Intersection Algorithm", JGT 10(1), 2005).
inline bool clip_to_box(const float lo[3], const float hi[3], const FrameRay& ray, float& s_min, float& s_max) {
  for (int i = 0; i < 3; ++i) {
    float a = (lo[i] - ray.origin[i]) * ray.reciprocal[i];
    float b = (hi[i] - ray.origin[i]) * ray.reciprocal[i];
    s_min = std::max(s_min, std::min(a, b));
    s_max = std::min(s_max, std::max(a, b));
  }
  return s_min <= s_max;
}

// The parameter at which the ray enters the box within [s_min, s_max], or kMissed.
inline float enter(const float lo[3], const float hi[3], const FrameRay& ray, float s_min, float s_max) {
  return clip_to_box(lo, hi, ray, s_min, s_max) ? s_min : kMissed;
}

// Where the ray crosses a plane. Rounded as the slabs are, so that what holds for boxes holds for cells: a primitive
// whose padded box meets every cell that the true point may be in is never lost.
inline float crossing(const FrameRay& ray, int axis, float plane) {
  return (plane - ray.origin[axis]) * ray.reciprocal[axis];
}

// Remembers the primitives last tested by a ray (Amanatides and Woo, "A Fast Voxel Traversal Algorithm for Ray
// Tracing", 1987; hashed so that it needs no room in the primitives). It may forget, and then a test is repeated.
class Mailbox {
 public:
  Mailbox() { std::fill_n(last_, kSlots, ~0u); }
  bool seen(uint32_t primitive) {
    uint32_t& slot = last_[primitive % kSlots];
    if (slot == primitive) return true;
    slot = primitive;
    return false;
  }

 private:
  static constexpr uint32_t kSlots = 32;
  uint32_t last_[kSlots];
};

}  // namespace tilecast
