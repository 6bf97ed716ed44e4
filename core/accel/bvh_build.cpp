// Top-down building: one loop, and four ways to part a node's primitives.
//
// The depth is bounded: beyond Bvh::kGroupingDepth nodes are halved by index, which also parts boxes that nothing tells
// apart.
#include <bit>
#include <numeric>

#include "accel/bvh.h"

namespace tilecast {
namespace {

constexpr uint32_t kLeafSize = Bvh::kLeafSize;

// What a way of grouping answers: how many items go left (the items are rearranged), or 0 for a leaf.
using Items = std::span<uint32_t>;

FrameBox centroid_bounds(const PrimitiveSet& primitives, Items items) {
  FrameBox out;
  for (uint32_t item : items) {
    const FrameBox& box = primitives.boxes[item];
    for (int i = 0; i < 3; ++i) {
      float c = box.centre(i);
      out.lo[i] = std::min(out.lo[i], c), out.hi[i] = std::max(out.hi[i], c);
    }
  }
  return out;
}

uint32_t halve(Items items) { return static_cast<uint32_t>(items.size() / 2); }

// Whether one item comes before another along an axis.
auto by_centre(const PrimitiveSet& primitives, int axis) {
  return [&primitives, axis](uint32_t a, uint32_t b) {
    float ca = primitives.boxes[a].centre(axis), cb = primitives.boxes[b].centre(axis);
    return ca < cb || (ca == cb && a < b);
  };
}

uint32_t part_by_sweep(const PrimitiveSet& primitives, Items items, const FrameBox& bounds) {
  float best_cost = FrameBox::kFar;
  int best_axis = 0;
  uint32_t best = 0;
  std::vector<float> right_area(items.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::sort(items.begin(), items.end(), by_centre(primitives, axis));
    FrameBox right, left;
    for (size_t i = items.size(); i-- > 1;) {
      right.extend(primitives.boxes[items[i]]);
      right_area[i] = right.half_area();
    }
    for (size_t i = 1; i < items.size(); ++i) {
      left.extend(primitives.boxes[items[i - 1]]);
      float cost = 1.0f + primitives.test_cost * (left.half_area() * i + right_area[i] * (items.size() - i)) /
                              bounds.half_area();
      if (cost < best_cost) best_cost = cost, best_axis = axis, best = static_cast<uint32_t>(i);
    }
  }
  if (items.size() <= kLeafSize && !(best_cost < primitives.test_cost * items.size())) return 0;
  if (best_axis != 2) std::sort(items.begin(), items.end(), by_centre(primitives, best_axis));
  return best;
}

uint32_t part_at_median(const PrimitiveSet& primitives, Items items) {
  if (items.size() <= kLeafSize) return 0;
  int axis = centroid_bounds(primitives, items).longest_axis();
  uint32_t left = halve(items);
  std::nth_element(items.begin(), items.begin() + left, items.end(), by_centre(primitives, axis));
  return left;
}

uint32_t part_at_middle(const PrimitiveSet& primitives, Items items) {
  if (items.size() <= kLeafSize) return 0;
  FrameBox centroids = centroid_bounds(primitives, items);
  int axis = centroids.longest_axis();
  float at = centroids.centre(axis);
  auto middle = std::partition(items.begin(), items.end(),
                               [&](uint32_t item) { return primitives.boxes[item].centre(axis) < at; });
  uint32_t left = static_cast<uint32_t>(middle - items.begin());
  return left == 0 || left == items.size() ? halve(items) : left;
}

// 21 bits an axis, interleaved.
uint64_t morton_code(const FrameBox& box, const FrameBox& centroids) {
  auto spread = [](uint64_t x) {
    x = (x | x << 32) & 0x1f00000000ffffull;
    x = (x | x << 16) & 0x1f0000ff0000ffull;
    x = (x | x << 8) & 0x100f00f00f00f00full;
    x = (x | x << 4) & 0x10c30c30c30c30c3ull;
    return (x | x << 2) & 0x1249249249249249ull;
  };
  uint64_t code = 0;
  for (int i = 0; i < 3; ++i) {
    float extent = centroids.extent(i);
    double place = extent > 0.0f ? (box.centre(i) - centroids.lo[i]) / static_cast<double>(extent) : 0.0;
    code |= spread(static_cast<uint64_t>(std::clamp(place * 0x1p21, 0.0, 0x1p21 - 1))) << (2 - i);
  }
  return code;
}

std::vector<uint64_t> sort_along_curve(const PrimitiveSet& primitives, Items items) {
  FrameBox centroids = centroid_bounds(primitives, items);
  std::vector<uint64_t> codes(primitives.size());
  for (uint32_t i = 0; i < codes.size(); ++i) codes[i] = morton_code(primitives.boxes[i], centroids);
  std::sort(items.begin(), items.end(),
            [&](uint32_t a, uint32_t b) { return codes[a] < codes[b] || (codes[a] == codes[b] && a < b); });
  return codes;
}

// Items are in the order of their codes: part where the highest bit that differs changes.
uint32_t part_along_curve(const std::vector<uint64_t>& codes, Items items) {
  if (items.size() <= kLeafSize) return 0;
  uint64_t differing = codes[items.front()] ^ codes[items.back()];
  if (differing == 0) return halve(items);
  uint64_t bit = std::bit_floor(differing);
  auto middle = std::partition_point(items.begin(), items.end(), [&](uint32_t item) { return !(codes[item] & bit); });
  return static_cast<uint32_t>(middle - items.begin());
}

}  // namespace

Bvh Bvh::build(const PrimitiveSet& primitives, Grouping grouping, std::vector<uint32_t>& order,
               int threads) {
  if (grouping == Grouping::Sah)  // with room for no splits
    return build_with_spatial_splits(primitives, primitives.size(), order, threads);
  order.resize(primitives.size());
  std::iota(order.begin(), order.end(), 0u);
  std::vector<uint64_t> codes;
  if (grouping == Grouping::Morton) codes = sort_along_curve(primitives, order);
  auto part = [&](Items items, const FrameBox& bounds) {
    switch (grouping) {
      case Grouping::SahSweep: return part_by_sweep(primitives, items, bounds);
      case Grouping::Median: return part_at_median(primitives, items);
      case Grouping::Middle: return part_at_middle(primitives, items);
      default: return part_along_curve(codes, items);
    }
  };

  Bvh bvh;
  struct Task {
    uint32_t node, first, count;
    int depth;
  };
  bvh.nodes_.reserve(primitives.size());
  bvh.nodes_.emplace_back();
  std::vector<Task> tasks{{0, 0, static_cast<uint32_t>(primitives.size()), 0}};
  while (!tasks.empty()) {
    Task task = tasks.back();
    tasks.pop_back();
    Items items(order.data() + task.first, task.count);
    FrameBox bounds;
    for (uint32_t item : items) bounds.extend(primitives.boxes[item]);
    Node& node = bvh.nodes_[task.node];
    node.set_box(bounds);
    node.first = task.first;
    node.count = task.count;
    if (task.count <= 1) continue;
    uint32_t left = 0;
    if (task.depth < kGroupingDepth) {
      left = part(items, bounds);
    } else if (task.count > kLeafSize) {
      left = halve(items);
    }
    if (left == 0) continue;
    uint32_t children = static_cast<uint32_t>(bvh.nodes_.size());
    node.first = children;
    node.count = 0;
    bvh.nodes_.resize(children + 2);
    tasks.push_back({children + 1, task.first + left, task.count - left, task.depth + 1});
    tasks.push_back({children, task.first, left, task.depth + 1});
  }
  bvh.nodes_.shrink_to_fit();
  return bvh;
}

double Bvh::expected_cost(float test_cost, uint32_t together) const {
  double sum = 0.0;
  for (const Node& node : nodes_) sum += node.box().half_area() * step_cost(node, test_cost, together);
  return 1.0 + sum / nodes_[0].box().half_area();
}

double Bvh::overlap_cost(float test_cost, uint32_t together) const {
  double sum = 0.0;
  for (const Node& node : nodes_) {
    if (node.count > 0) continue;
    const Node& other = nodes_[node.first + 1];
    const FrameBox shared = nodes_[node.first].box().intersected(other.box());
    if (!shared.empty()) sum += shared.half_area() * step_cost(other, test_cost, together);
  }
  return sum / nodes_[0].box().half_area();
}

int Bvh::depth() const {
  std::vector<uint8_t> depth(nodes_.size());
  int deepest = 0;
  std::vector<uint32_t> pending{0};
  while (!pending.empty()) {
    uint32_t i = pending.back();
    pending.pop_back();
    deepest = std::max<int>(deepest, depth[i]);
    if (nodes_[i].count > 0 || depth[i] == 255) continue;
    for (uint32_t child : {nodes_[i].first, nodes_[i].first + 1}) {
      depth[child] = depth[i] + 1;
      pending.push_back(child);
    }
  }
  return deepest;
}

}  // namespace tilecast
