// No acceleration: every primitive, in order. The oracle that the others are tested against.
//
// Objects, which are dear to test, are looked at only where the ray meets their box; triangles always.
#pragma once

#include <numeric>
#include <vector>

#include "accel/traversal.h"

namespace tilecast {

struct BruteForce {
  uint32_t count = 0;
  std::vector<FrameBox> boxes;  // of every primitive, or none

  static BruteForce build(const PrimitiveSet& primitives, std::vector<uint32_t>& order) {
    order.resize(primitives.size());
    std::iota(order.begin(), order.end(), 0u);
    BruteForce all{static_cast<uint32_t>(primitives.size()), {}};
    if (primitives.test_cost > 1.0f) all.boxes.assign(primitives.boxes.begin(), primitives.boxes.end());
    return all;
  }

  size_t node_count() const { return 0; }
  uint64_t bytes() const { return boxes.size() * sizeof(FrameBox); }
  // Boxes in a row are looked at for half of a step.
  double expected_cost(float test_cost) const {
    if (boxes.empty()) return count * static_cast<double>(test_cost);
    FrameBox all;
    for (const FrameBox& box : boxes) all.extend(box);
    double met = 0.0;
    for (const FrameBox& box : boxes) met += double(box.half_area()) / all.half_area();
    return 0.5 * count + test_cost * met;
  }

  template <class Cost, class Leaf>
  bool traverse(const FrameRay& ray, float s_min, const float& s_max, Cost& cost, Leaf&& leaf) const {
    if (boxes.empty()) return count > 0 && leaf(0u, count);
    for (uint32_t i = 0; i < count; ++i) {
      cost.step();
      if (enter(boxes[i].lo, boxes[i].hi, ray, s_min, s_max) != kMissed && leaf(i, 1u)) return true;
    }
    return false;
  }
};

}  // namespace tilecast
