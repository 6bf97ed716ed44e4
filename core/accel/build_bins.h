// Bins along all three axes of a range of items, the cheapest place between two of them, and parting the range there.
//
// Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", RT 2007; in vectors as in Wald, "Fast
// Construction of SAH BVHs on the Intel Many Integrated Core (MIC) Architecture", TVCG 18(1), 2012.
#pragma once

#include "accel/build_item.h"

namespace tilecast {

struct BuildRange {
  uint32_t first, count, end;  // end: of the room for its items, and for parts of those that are cut
  int depth;
  Eight bounds, centres;  // joined
};

// The bins of three places, 0 to count - 1: what lies outside would be written through.
inline Four32 bins_at(Four place, int count) {
  const float last = static_cast<float>(count - 1);
  place = place > 0.0f ? place : Four{};
  return __builtin_convertvector(place < last ? place : Four{} + last, Four32);
}

class BuildBins {
 public:
  static constexpr int kMostBins = 32;
  static constexpr uint32_t kMany = 1000, kFew = 8;  // items: more take all bins, not more a quarter, others half

  explicit BuildBins(const BuildRange& range)
      : bins_(range.count > kMany ? kMostBins : range.count > kFew ? kMostBins / 2 : kMostBins / 4) {
    const Four lo = low_half(range.centres), extent = -(lo + high_half(range.centres));
    for (int axis = 0; axis < 3; ++axis) {
      // Less cannot be told apart, and its reciprocal may overflow.
      const bool flat = !(extent[axis] > 0x1p-80f);
      lo_[axis] = lo[axis];
      scale_[axis] = flat ? 0.0f : bins_ * (1.0f - 0x1p-20f) / extent[axis];
    }
    for (auto& boxes : boxes_) std::fill_n(boxes, bins_, kNothing);
    std::fill_n(counts_, bins_, Four32{});
  }

  void add(const BuildItem* items, uint32_t count) {
    for (uint32_t i = 0; i < count; ++i) {
      const BuildItem item = items[i];
      const Four32 bin = bins_at((low_half(item.centre()) - lo_) * scale_, kMostBins);
      for (int axis = 0; axis < 3; ++axis) {
        const uint32_t b = static_cast<uint32_t>(bin[axis]);
        boxes_[axis][b] = least(boxes_[axis][b], item.lanes);
        ++counts_[b][axis];
      }
    }
  }
  void add(const BuildBins& other) {
    for (int b = 0; b < bins_; ++b) {
      for (int axis = 0; axis < 3; ++axis) boxes_[axis][b] = least(boxes_[axis][b], other.boxes_[axis][b]);
      counts_[b] += other.counts_[b];
    }
  }

  struct Split {
    int axis = -1;     // -1: there is none
    int bin = 0;       // the first of the right side
    float cost = kFar;  // areas times tests
  };
  // tests(counts): what the items cost to test.
  template <class Tests>
  Split best_split(Tests&& tests) const {
    Four right_cost[kMostBins];
    Eight box[3] = {kNothing, kNothing, kNothing};
    Four32 count{};
    auto join = [&](int b) {
      for (int axis = 0; axis < 3; ++axis) box[axis] = least(box[axis], boxes_[axis][b]);
      count += counts_[b];
      return half_areas(box[0], box[1], box[2]) * tests(count);  // NaN where there are none
    };
    for (int b = bins_ - 1; b > 0; --b) right_cost[b] = join(b);
    std::fill_n(box, 3, kNothing);
    count = Four32{};
    Four best = {kFar, kFar, kFar, kFar};
    Four32 best_bin{};
    for (int b = 1; b < bins_; ++b) {
      const Four cost = join(b - 1) + right_cost[b];
      const Four32 better = cost < best;
      best = better ? cost : best;
      best_bin = better ? Four32{b, b, b, b} : best_bin;
    }
    Split out;
    for (int axis = 0; axis < 3; ++axis)
      if (scale_[axis] > 0.0f && best[axis] < out.cost) out = {axis, best_bin[axis], best[axis]};
    return out;
  }

  // Half the surface of what both sides' boxes share.
  float overlap(const Split& split) const {
    Eight sides[2] = {kNothing, kNothing};
    for (int b = 0; b < bins_; ++b) {
      Eight& side = sides[b >= split.bin];
      side = least(side, boxes_[split.axis][b]);
    }
    const FrameBox shared = box_of(sides[0]).intersected(box_of(sides[1]));
    return shared.empty() ? 0.0f : shared.half_area();
  }

  // Moves what lies left of the split to the front; the ranges get all but their depth
  // and their room. Each item trades places with
  // the first of the right side, wherever it belongs, so that nothing has to be foreseen.
  void part(BuildItem* items, const BuildRange& range, const Split& split, BuildRange& left, BuildRange& right) const {
    left.bounds = right.bounds = kNothing;
    for (int b = 0; b < bins_; ++b) {
      Eight& bounds = b < split.bin ? left.bounds : right.bounds;
      bounds = least(bounds, boxes_[split.axis][b]);
    }
    const Eight32 lane = Eight32{} + split.axis;
    const float lo = lo_[split.axis], scale = scale_[split.axis], plane = static_cast<float>(split.bin);
    BuildItem* middle = items + range.first;
    Eight left_centres = kNothing, right_centres = kNothing;
    for (BuildItem *i = middle, *end = i + range.count; i < end; ++i) {
      const BuildItem item = *i;
      const Eight centre = item.centre();
      const Eight32 is_left = (__builtin_shuffle(centre, lane) - lo) * scale < plane;
      *i = *middle;
      *middle = item;
      middle -= is_left[0];
      left_centres = least(left_centres, is_left ? centre : kNothing);
      right_centres = least(right_centres, is_left ? kNothing : centre);
    }
    left.centres = left_centres, right.centres = right_centres;
    left.first = range.first;
    left.count = static_cast<uint32_t>(middle - items) - range.first;
    right.first = range.first + left.count;
    right.count = range.count - left.count;
  }

 private:
  const int bins_;
  Four lo_{}, scale_{};
  Eight boxes_[3][kMostBins];
  Four32 counts_[kMostBins];
};

// The joined boxes and centres of a range's items.
inline void measure(const BuildItem* items, BuildRange& range) {
  range.bounds = range.centres = kNothing;
  for (const BuildItem *i = items + range.first, *end = i + range.count; i < end; ++i) {
    range.bounds = least(range.bounds, i->lanes);
    range.centres = least(range.centres, i->centre());
  }
}

}  // namespace tilecast
