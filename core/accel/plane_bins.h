// Planes that may cut a range's items, sixteen stretches along each axis, and parting the range at one: what is cut stands on
// both sides, each time with the box of its part.
//
// Stich, Friedrich and Dietrich, "Spatial Splits in Bounding Volume Hierarchies", HPG 2009. (Their unsplitting is left out:
// where many long objects cross a plane, each one that stays whole makes the next one cheaper to keep, until nothing is
// split.)
#pragma once

#include "accel/build_bins.h"

namespace tilecast {

class PlaneBins {
 public:
  static constexpr int kBins = 16;

  PlaneBins(const BuildRange& range, const PrimitiveSet& primitives) : primitives_(primitives) {
    lo_ = low_half(range.bounds);
    const Four extent = -(lo_ + high_half(range.bounds));
    for (int axis = 0; axis < 3; ++axis) {
      wide_[axis] = extent[axis] > 4 * kBins * kBoxPadding;
      width_[axis] = extent[axis] / kBins;
      scale_[axis] = wide_[axis] ? kBins * (1.0f - 0x1p-20f) / extent[axis] : 0.0f;
    }
    for (auto& boxes : boxes_) std::fill_n(boxes, kBins, kNothing);
  }

  void add(const BuildItem* items, uint32_t count) {
    for (uint32_t i = 0; i < count; ++i) {
      const Eight item = items[i].lanes;
      const Four32 first = bin(low_half(item) + kBoxPadding), last = bin(-high_half(item) - kBoxPadding);
      for (int axis = 0; axis < 3; ++axis) {
        if (!wide_[axis]) continue;
        ++begins_[first[axis]][axis], ++ends_[last[axis]][axis];
        if (first[axis] >= last[axis]) {
          boxes_[axis][first[axis]] = least(boxes_[axis][first[axis]], item);
        } else if (primitives_.mesh) {
          chop(items[i], axis, first[axis], last[axis]);
        } else {
          for (int b = first[axis]; b <= last[axis]; ++b) {
            Eight part = item;
            part[axis] = std::max(part[axis], plane(axis, b) - kBoxPadding);
            part[4 + axis] = std::max(part[4 + axis], -plane(axis, b + 1) - kBoxPadding);
            boxes_[axis][b] = least(boxes_[axis][b], part);
          }
        }
      }
    }
  }

  void add(const PlaneBins& other) {
    for (int b = 0; b < kBins; ++b) {
      for (int axis = 0; axis < 3; ++axis) boxes_[axis][b] = least(boxes_[axis][b], other.boxes_[axis][b]);
      begins_[b] += other.begins_[b], ends_[b] += other.ends_[b];
    }
  }

  struct Split {
    int axis = -1;  // -1: there is none
    float plane = 0.0f, cost = kFar;  // areas times tests
  };
  // The cheapest plane that adds at most `room` items to the `count` that there are; tests(counts): what they cost to test.
  template <class Tests>
  Split best_split(uint32_t count, uint32_t room, Tests&& tests) const {
    Four right_cost[kBins];
    Four32 right_count[kBins];
    Eight box[3] = {kNothing, kNothing, kNothing};
    Four32 items{};
    auto join = [&](int b, const Four32& more) {
      for (int axis = 0; axis < 3; ++axis) box[axis] = least(box[axis], boxes_[axis][b]);
      items += more;
      return half_areas(box[0], box[1], box[2]) * tests(items);  // NaN where there are none
    };
    for (int b = kBins - 1; b > 0; --b) right_cost[b] = join(b, ends_[b]), right_count[b] = items;
    std::fill_n(box, 3, kNothing);
    items = Four32{};
    Split best;
    const int32_t most = static_cast<int32_t>(count + room);
    for (int b = 1; b < kBins; ++b) {
      const Four cost = join(b - 1, begins_[b - 1]) + right_cost[b];
      const Four32 both = items + right_count[b];
      for (int axis = 0; axis < 3; ++axis)
        if (wide_[axis] && both[axis] <= most && cost[axis] < best.cost) best = {axis, plane(axis, b), cost[axis]};
    }
    return best;
  }

  // Moves what lies left of the plane to the front of the range, and what is to the right of it, with its share of what is
  // cut, behind; the ranges get all but their depth and their room. False, with the range unchanged but for its order, where a
  // side would stay empty.
  static bool part(const PrimitiveSet& primitives, BuildItem* items, const BuildRange& range, const Split& split,
                   BuildRange& left, BuildRange& right) {
    const int axis = split.axis;
    uint32_t room = range.end - range.first - range.count;
    std::vector<BuildItem> cut;  // their right parts
    BuildItem* middle = items + range.first;
    for (BuildItem *i = middle, *end = i + range.count; i < end; ++i) {
      BuildItem item = *i;
      const float lo = item.lanes[axis] + kBoxPadding, hi = -item.lanes[4 + axis] - kBoxPadding;
      bool to_left = 0.5f * lo + 0.5f * hi < split.plane;
      if (lo < split.plane && split.plane < hi && room > 0) {
        FrameBox a = box_of(item.lanes).padded(-kBoxPadding), b = a;
        a.hi[axis] = b.lo[axis] = split.plane;
        const bool in_left = primitives.clip_to(item.primitive(), a), in_right = primitives.clip_to(item.primitive(), b);
        if (in_left && in_right) {
          cut.push_back(BuildItem::of(b.padded(kBoxPadding), item.primitive()));
          item = BuildItem::of(a.padded(kBoxPadding), item.primitive());
          to_left = true, --room;
        } else if (in_left != in_right) {
          to_left = in_left;
        }
      }
      *i = *middle;
      *middle = item;
      middle += to_left;
    }
    left.first = range.first;
    left.count = static_cast<uint32_t>(middle - items) - range.first;
    right.first = range.first + left.count;
    right.count = range.count - left.count + static_cast<uint32_t>(cut.size());
    std::copy(cut.begin(), cut.end(), items + range.first + range.count);
    measure(items, left);
    measure(items, right);
    return left.count > 0 && right.count > 0;
  }

 private:
  Four32 bin(Four at) const { return bins_at((at - lo_) * scale_, kBins); }
  float plane(int axis, int b) const { return lo_[axis] + static_cast<float>(b) * width_[axis]; }

  // Extends the boxes of the bins first .. last by what of a triangle lies between their planes: its edges are followed from
  // plane to plane.
  void chop(const BuildItem& item, int axis, int first, int last) {
    Eight parts[kBins];
    std::fill(parts + first, parts + last + 1, kNothing);
    auto add = [&](int b, const Four& p) {
      if (b < first || b > last) return;
      parts[b] = least(parts[b], __builtin_shufflevector(p, -p, 0, 1, 2, 3, 4, 5, 6, 7));
    };
    const Triangle triangle = primitives_.mesh->triangle(item.primitive());
    auto corner = [](const Vec3f& v) { return Four{v.x, v.y, v.z, 0.0f}; };
    const Four corners[3] = {corner(triangle.a), corner(triangle.b), corner(triangle.c)};
    int bins[3];
    for (int k = 0; k < 3; ++k) bins[k] = bin(corners[k])[axis], add(bins[k], corners[k]);
    for (int k = 0; k < 3; ++k) {
      int i = k, j = (k + 1) % 3;
      if (bins[i] == bins[j]) continue;
      if (bins[i] > bins[j]) std::swap(i, j);
      const Four a = corners[i], slope = (corners[j] - a) / (corners[j][axis] - a[axis]);
      for (int at = std::max(bins[i], first - 1) + 1; at <= std::min(bins[j], last + 1); ++at) {
        const Four p = a + (plane(axis, at) - a[axis]) * slope;
        add(at - 1, p);
        add(at, p);
      }
    }
    for (int b = first; b <= last; ++b) {
      const Eight part = parts[b] - kBoxPadding, both = part > item.lanes ? part : item.lanes;
      const Four gap = low_half(both) + high_half(both);
      if (gap[0] <= 0.0f && gap[1] <= 0.0f && gap[2] <= 0.0f) boxes_[axis][b] = least(boxes_[axis][b], both);
    }
  }

  const PrimitiveSet& primitives_;
  bool wide_[3];
  Four lo_, width_{}, scale_{};
  Eight boxes_[3][kBins];
  Four32 begins_[kBins] = {}, ends_[kBins] = {};  // items, by the bins where they begin and end
};

}  // namespace tilecast
