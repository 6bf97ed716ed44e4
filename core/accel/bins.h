// Sixteen bins along each axis of the centroids' box, and the cheapest place between two of them.
//
// Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007.
#pragma once

#include "accel/frame_box.h"

namespace tilecast {

struct ObjectSplit {
  int axis = -1;  // -1: there is none
  int bin = 0;    // the first bin of the right side
  float cost = FrameBox::kFar;
  float overlap = 0.0f;  // half the surface of what both sides' boxes share
};

// items: any range; box_of(item) gives the FrameBox.
template <class Items, class BoxOf>
FrameBox centroid_bounds(const Items& items, BoxOf&& box_of) {
  FrameBox out;
  for (const auto& item : items) {
    const FrameBox& box = box_of(item);
    for (int i = 0; i < 3; ++i) {
      float c = box.centre(i);
      out.lo[i] = std::min(out.lo[i], c), out.hi[i] = std::max(out.hi[i], c);
    }
  }
  return out;
}

class Bins {
 public:
  static constexpr int kCount = 16;

  template <class Items, class BoxOf>
  Bins(const Items& items, BoxOf&& box_of) {
    const FrameBox centroids = centroid_bounds(items, box_of);
    for (int i = 0; i < 3; ++i) {
      lo_[i] = centroids.lo[i];
      scale_[i] = centroids.extent(i) > 0.0f ? kCount * (1.0f - 0x1p-20f) / centroids.extent(i) : 0.0f;
    }
  }

  int bin(const FrameBox& box, int axis) const {
    return std::clamp(static_cast<int>((box.centre(axis) - lo_[axis]) * scale_[axis]), 0, kCount - 1);
  }

  // Costs are in steps to a child; area: half the surface of the node.
  template <class Items, class BoxOf>
  ObjectSplit best_split(const Items& items, BoxOf&& box_of, float area, float test_cost) const {
    ObjectSplit best;
    for (int axis = 0; axis < 3; ++axis) {
      if (scale_[axis] == 0.0f) continue;
      FrameBox bounds[kCount];
      uint32_t counts[kCount] = {};
      for (const auto& item : items) {
        const FrameBox& box = box_of(item);
        int b = bin(box, axis);
        bounds[b].extend(box);
        ++counts[b];
      }
      FrameBox right[kCount];  // right[b]: bins b and up
      uint32_t right_count[kCount];
      right[kCount - 1] = bounds[kCount - 1], right_count[kCount - 1] = counts[kCount - 1];
      for (int b = kCount - 2; b > 0; --b) {
        right[b] = right[b + 1], right_count[b] = right_count[b + 1] + counts[b];
        right[b].extend(bounds[b]);
      }
      FrameBox left;
      uint32_t left_count = 0;
      for (int b = 1; b < kCount; ++b) {
        left.extend(bounds[b - 1]);
        left_count += counts[b - 1];
        if (left_count == 0 || right_count[b] == 0) continue;
        float cost = 1.0f + test_cost * (left.half_area() * left_count + right[b].half_area() * right_count[b]) / area;
        if (cost < best.cost) {
          FrameBox shared = left.intersected(right[b]);
          best = {axis, b, cost, shared.empty() ? 0.0f : shared.half_area()};
        }
      }
    }
    return best;
  }

 private:
  float lo_[3], scale_[3];
};

}  // namespace tilecast
