// A hierarchy with objects in more than one box.
//
// Stich, Friedrich and Dietrich, "Spatial Splits in Bounding Volume Hierarchies", HPG 2009: where the boxes of the best
// object split overlap, planes are tried as well; what a plane cuts is referenced on both sides by the box of its part.
// Every node may add references in proportion to those it has, so that memory is bounded whatever the scene; a plane
// that would cut more is not taken. (Stich's unsplitting is left out: where many long objects cross a plane, each one
// that stays whole makes the next one cheaper to keep, until nothing is split.)
#include "accel/bins.h"
#include "accel/bvh.h"
#include "accel/reference.h"

namespace tilecast {
namespace {

constexpr float kOverlap = 1e-4f;  // of the root's surface: less is not worth a plane
// What overlaps is paid for again further down, which the heuristic does not see: a plane may look this much dearer.
constexpr float kPreference = 1.1f;
constexpr int kPlaneBins = 16;
constexpr size_t kFewest = 5;  // references that a plane is tried on

const FrameBox& box_of(const Reference& reference) { return reference.box; }

struct PlaneSplit {
  int axis = -1;
  float plane = 0.0f, cost = FrameBox::kFar;
};

class Builder {
 public:
  explicit Builder(const PrimitiveSet& primitives) : primitives_(primitives) {}

  // The part of a reference between lo and hi on an axis; false where there is none.
  bool part_of(const Reference& whole, int axis, float lo, float hi, Reference& part) const {
    part = whole;
    for (int i = 0; i < 3; ++i) part.box.lo[i] += kBoxPadding, part.box.hi[i] -= kBoxPadding;
    part.box.lo[axis] = std::max(part.box.lo[axis], lo);
    part.box.hi[axis] = std::min(part.box.hi[axis], hi);
    if (part.box.empty() || !primitives_.clip_to(whole.primitive, part.box)) return false;
    part.box = part.box.padded(kBoxPadding);
    return true;
  }

  // Extends the boxes of the bins first .. last by what of the reference lies between their planes. A triangle's edges
  // are followed from plane to plane.
  template <class Plane, class Bin>
  void chop(const Reference& item, int axis, int first, int last, Plane&& plane, Bin&& bin, FrameBox boxes[]) const {
    FrameBox parts[kPlaneBins];
    auto add = [&](int b, const Vec3f& p) {
      if (b < first || b > last) return;
      for (int i = 0; i < 3; ++i) {
        parts[b].lo[i] = std::min(parts[b].lo[i], p[i] - kBoxPadding);
        parts[b].hi[i] = std::max(parts[b].hi[i], p[i] + kBoxPadding);
      }
    };
    if (primitives_.mesh) {
      const Triangle triangle = primitives_.mesh->triangle(item.primitive);
      const Vec3f corners[3] = {triangle.a, triangle.b, triangle.c};
      for (int k = 0; k < 3; ++k) {
        Vec3f a = corners[k], b = corners[(k + 1) % 3];
        add(bin(a[axis]), a);
        if (a[axis] > b[axis]) std::swap(a, b);
        const int from = std::max(bin(a[axis]), first - 1), to = std::min(bin(b[axis]), last + 1);
        const Vec3f slope = from < to ? (b - a) / (b[axis] - a[axis]) : Vec3f(0.0f);
        for (int at = from + 1; at <= to; ++at) {
          Vec3f p = a + (plane(at) - a[axis]) * slope;
          add(at - 1, p);
          add(at, p);
        }
      }
    } else {
      for (int b = first; b <= last; ++b) {
        parts[b] = item.box;
        parts[b].lo[axis] = std::max(parts[b].lo[axis], plane(b) - kBoxPadding);
        parts[b].hi[axis] = std::min(parts[b].hi[axis], plane(b + 1) + kBoxPadding);
      }
    }
    for (int b = first; b <= last; ++b) {
      FrameBox part = parts[b].intersected(item.box);
      if (!part.empty()) boxes[b].extend(part);
    }
  }

  PlaneSplit best_plane(const References& items, const FrameBox& bounds, size_t allowed) const {
    PlaneSplit best;
    const int bins = items.size() < 32 ? kPlaneBins / 2 : kPlaneBins;
    for (int axis = 0; axis < 3; ++axis) {
      const float width = bounds.extent(axis) / bins;
      if (!(width > 4 * kBoxPadding)) continue;
      auto plane = [&](int b) { return bounds.lo[axis] + b * width; };
      auto bin = [&](float x) {
        return static_cast<int>(std::clamp((x - bounds.lo[axis]) / width, 0.0f, static_cast<float>(bins - 1)));
      };
      FrameBox boxes[kPlaneBins];
      uint32_t begins[kPlaneBins] = {}, ends[kPlaneBins] = {};
      for (const Reference& item : items) {
        int first = bin(item.box.lo[axis] + kBoxPadding), last = bin(item.box.hi[axis] - kBoxPadding);
        ++begins[first], ++ends[last];
        if (first == last) {
          boxes[first].extend(item.box);
        } else {
          chop(item, axis, first, last, plane, bin, boxes);
        }
      }
      FrameBox right[kPlaneBins];
      right[bins - 1] = boxes[bins - 1];
      for (int b = bins - 2; b > 0; --b) right[b] = right[b + 1], right[b].extend(boxes[b]);
      FrameBox left;
      size_t left_count = 0, right_count = items.size();
      for (int b = 1; b < bins; ++b) {
        left.extend(boxes[b - 1]);
        left_count += begins[b - 1], right_count -= ends[b - 1];
        if (left_count == 0 || right_count == 0) continue;
        float tests = left.half_area() * left_count + right[b].half_area() * right_count;
        float cost = 1.0f + primitives_.test_cost * tests / bounds.half_area();
        if (left_count + right_count <= items.size() + allowed && cost < best.cost) best = {axis, plane(b), cost};
      }
    }
    return best;
  }

  // False where a side would stay empty, or more than `allowed` references would be added.
  bool part_at_plane(const References& items, const PlaneSplit& split, size_t allowed, References& left,
                     References& right) const {
    for (const Reference& item : items) {
      Reference a, b;
      bool in_left = part_of(item, split.axis, -FrameBox::kFar, split.plane, a);
      bool in_right = part_of(item, split.axis, split.plane, FrameBox::kFar, b);
      if (in_left && in_right) {
        left.push_back(a);
        right.push_back(b);
      } else {
        bool to_left = in_left || (!in_right && item.box.centre(split.axis) < split.plane);
        (to_left ? left : right).push_back(item);
      }
    }
    return !left.empty() && !right.empty() && left.size() + right.size() <= items.size() + allowed;
  }

  void part_by_bins(const References& items, const Bins& bins, const ObjectSplit& split, References& left,
                    References& right) const {
    for (size_t i = 0; i < items.size(); ++i) {
      bool to_left = split.axis < 0 ? i < items.size() / 2 : bins.bin(items[i].box, split.axis) < split.bin;
      (to_left ? left : right).push_back(items[i]);
    }
  }

 private:
  const PrimitiveSet& primitives_;
};

}  // namespace

Bvh Bvh::build_with_spatial_splits(const PrimitiveSet& primitives, size_t most_references,
                                   std::vector<uint32_t>& order) {
  Bvh bvh;
  Builder builder(primitives);
  const float root_area = primitives.bounds().half_area(), test_cost = primitives.test_cost;
  struct Task {
    uint32_t node;
    int depth;
    size_t allowed;  // references that may be added below
    References items;
  };
  std::vector<Task> tasks;
  tasks.push_back({0, 0, most_references - primitives.size(), references_to(primitives)});
  order.clear();
  order.reserve(most_references);
  bvh.nodes_.emplace_back();
  while (!tasks.empty()) {
    Task task = std::move(tasks.back());
    tasks.pop_back();
    FrameBox bounds;
    for (const Reference& item : task.items) bounds.extend(item.box);
    const size_t count = task.items.size();
    References left, right;
    if (count > 1 && (task.depth < kGroupingDepth || count > kLeafSize)) {
      Bins bins(task.items, box_of);
      ObjectSplit objects;
      PlaneSplit plane;
      if (task.depth < kGroupingDepth) {
        objects = bins.best_split(task.items, box_of, bounds.half_area(), test_cost);
        if (task.allowed > 0 && count >= kFewest && (objects.axis < 0 || objects.overlap > kOverlap * root_area))
          plane = builder.best_plane(task.items, bounds, task.allowed);
      }
      if (count > kLeafSize || std::min(objects.cost, plane.cost) < test_cost * count) {
        bool cut = plane.cost < kPreference * objects.cost &&
                   builder.part_at_plane(task.items, plane, task.allowed, left, right);
        if (!cut) {
          left.clear(), right.clear();
          builder.part_by_bins(task.items, bins, objects, left, right);
        }
      }
    }
    Node& node = bvh.nodes_[task.node];
    node.set_box(bounds);
    if (left.empty() || right.empty()) {
      node.first = static_cast<uint32_t>(order.size());
      node.count = static_cast<uint32_t>(count);
      for (const Reference& item : task.items) order.push_back(item.primitive);
      continue;
    }
    uint32_t children = static_cast<uint32_t>(bvh.nodes_.size());
    node.first = children;
    node.count = 0;
    size_t allowed = task.allowed - (left.size() + right.size() - count);
    size_t to_left = static_cast<size_t>(static_cast<double>(allowed) * left.size() / (left.size() + right.size()));
    bvh.nodes_.resize(children + 2);
    tasks.push_back({children + 1, task.depth + 1, allowed - to_left, std::move(right)});
    tasks.push_back({children, task.depth + 1, to_left, std::move(left)});
  }
  bvh.nodes_.shrink_to_fit();
  order.shrink_to_fit();
  return bvh;
}

}  // namespace tilecast
