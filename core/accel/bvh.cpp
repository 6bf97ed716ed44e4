#include "accel/bvh.h"

#include <numeric>

namespace tilecast {
namespace {

constexpr int kBins = 16;
constexpr uint32_t kLeafSize = 4;
constexpr int kHeuristicDepth = 38;  // from here on halves by index: at most 32 levels more

struct Bounds {
  float lo[3] = {kMax, kMax, kMax}, hi[3] = {-kMax, -kMax, -kMax};
  static constexpr float kMax = std::numeric_limits<float>::infinity();

  void extend(const FrameBox& b) {
    for (int i = 0; i < 3; ++i) lo[i] = std::min(lo[i], b.lo[i]), hi[i] = std::max(hi[i], b.hi[i]);
  }
  void extend(const Bounds& b) {
    for (int i = 0; i < 3; ++i) lo[i] = std::min(lo[i], b.lo[i]), hi[i] = std::max(hi[i], b.hi[i]);
  }
  float half_area() const {
    float x = hi[0] - lo[0], y = hi[1] - lo[1], z = hi[2] - lo[2];
    return x < 0.0f ? 0.0f : x * y + y * z + z * x;
  }
};

float centroid(const FrameBox& b, int axis) { return 0.5f * b.lo[axis] + 0.5f * b.hi[axis]; }

struct Split {
  int axis = -1;
  int bin = 0;  // the first bin of the right side
  float cost = Bounds::kMax;
};

struct Binning {
  float lo[3], scale[3];

  Binning(std::span<const FrameBox> boxes, std::span<const uint32_t> items) {
    float high[3];
    for (int i = 0; i < 3; ++i) lo[i] = Bounds::kMax, high[i] = -Bounds::kMax;
    for (uint32_t item : items)
      for (int i = 0; i < 3; ++i) {
        float c = centroid(boxes[item], i);
        lo[i] = std::min(lo[i], c), high[i] = std::max(high[i], c);
      }
    for (int i = 0; i < 3; ++i) scale[i] = high[i] > lo[i] ? kBins * (1.0f - 0x1p-20f) / (high[i] - lo[i]) : 0.0f;
  }
  int bin(const FrameBox& box, int axis) const {
    return std::clamp(static_cast<int>((centroid(box, axis) - lo[axis]) * scale[axis]), 0, kBins - 1);
  }
};

Split best_split(std::span<const FrameBox> boxes, std::span<const uint32_t> items, const Binning& binning, float area,
                 float test_cost) {
  Split best;
  for (int axis = 0; axis < 3; ++axis) {
    if (binning.scale[axis] == 0.0f) continue;
    Bounds bounds[kBins];
    uint32_t counts[kBins] = {};
    for (uint32_t item : items) {
      int b = binning.bin(boxes[item], axis);
      bounds[b].extend(boxes[item]);
      ++counts[b];
    }
    float right_cost[kBins];
    Bounds right;
    uint32_t right_count = 0;
    for (int b = kBins - 1; b > 0; --b) {
      right.extend(bounds[b]);
      right_count += counts[b];
      right_cost[b] = right.half_area() * right_count;
    }
    Bounds left;
    uint32_t left_count = 0;
    for (int b = 1; b < kBins; ++b) {
      left.extend(bounds[b - 1]);
      left_count += counts[b - 1];
      if (left_count == 0 || left_count == items.size()) continue;
      float cost = 1.0f + test_cost * (left.half_area() * left_count + right_cost[b]) / area;
      if (cost < best.cost) best = {axis, b, cost};
    }
  }
  return best;
}

}  // namespace

FrameBox FrameBox::around(const Frame& frame, const Box& box) {
  FrameBox out;
  Vec3 lo = frame.to_frame(box.lo), hi = frame.to_frame(box.hi);
  for (int i = 0; i < 3; ++i) {
    out.lo[i] = std::nextafter(static_cast<float>(lo[i]) - kBoxPadding, -2.0f);
    out.hi[i] = std::nextafter(static_cast<float>(hi[i]) + kBoxPadding, 2.0f);
  }
  return out;
}

Bvh Bvh::build(std::span<const FrameBox> boxes, float test_cost, std::vector<uint32_t>& order) {
  Bvh bvh;
  order.resize(boxes.size());
  std::iota(order.begin(), order.end(), 0u);
  struct Task {
    uint32_t node, first, count;
    int depth;
  };
  bvh.nodes_.reserve(boxes.size());
  bvh.nodes_.emplace_back();
  std::vector<Task> tasks{{0, 0, static_cast<uint32_t>(boxes.size()), 0}};
  while (!tasks.empty()) {
    Task task = tasks.back();
    tasks.pop_back();
    std::span<uint32_t> items(order.data() + task.first, task.count);
    Bounds bounds;
    for (uint32_t item : items) bounds.extend(boxes[item]);
    Node& node = bvh.nodes_[task.node];
    for (int i = 0; i < 3; ++i) node.lo[i] = bounds.lo[i], node.hi[i] = bounds.hi[i];
    node.first = task.first;
    node.count = task.count;
    if (task.count <= 1) continue;

    Binning binning(boxes, items);
    Split split;
    if (task.depth < kHeuristicDepth) split = best_split(boxes, items, binning, bounds.half_area(), test_cost);
    if (task.count <= kLeafSize && !(split.cost < test_cost * task.count)) continue;
    uint32_t left = task.count / 2;
    if (split.axis >= 0) {
      auto middle = std::partition(items.begin(), items.end(), [&](uint32_t item) {
        return binning.bin(boxes[item], split.axis) < split.bin;
      });
      left = static_cast<uint32_t>(middle - items.begin());
    }
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

}  // namespace tilecast
