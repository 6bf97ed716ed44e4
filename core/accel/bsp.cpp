#include "accel/bsp.h"

#include "accel/reference.h"

namespace tilecast {
namespace {

constexpr int kBins = 32;
constexpr size_t kSorted = 64;           // nodes of at most this many items try every side of their boxes
constexpr float kEmptyBonus = 0.8f;      // on the cost where a side is empty: such planes cut off space early
constexpr float kMedianLeafCost = 4.0f;  // of the tests in a leaf

struct Split {
  int axis = -1;
  float plane = 0.0f, cost = FrameBox::kFar;
};

// The cost of a plane, in steps.
float cost_of(const FrameBox& cell, int axis, float plane, size_t left_count, size_t right_count, float test_cost) {
  FrameBox left = cell, right = cell;
  left.hi[axis] = right.lo[axis] = plane;
  float tests = test_cost * (left.half_area() * left_count + right.half_area() * right_count) / cell.half_area();
  return 1.0f + tests * (left_count == 0 || right_count == 0 ? kEmptyBonus : 1.0f);
}

Split best_of_bins(const References& items, const FrameBox& cell, float test_cost) {
  Split best;
  for (int axis = 0; axis < 3; ++axis) {
    const float width = cell.extent(axis) / kBins;
    if (!(width > 0.0f)) continue;
    auto bin = [&](float x) { return std::clamp(static_cast<int>((x - cell.lo[axis]) / width), 0, kBins - 1); };
    size_t begins[kBins] = {}, ends[kBins] = {};
    for (const Reference& item : items) ++begins[bin(item.box.lo[axis])], ++ends[bin(item.box.hi[axis])];
    size_t left = 0, right = items.size();
    for (int b = 1; b < kBins; ++b) {
      left += begins[b - 1], right -= ends[b - 1];
      float plane = cell.lo[axis] + b * width;
      float cost = cost_of(cell, axis, plane, left, right, test_cost);
      if (cost < best.cost) best = {axis, plane, cost};
    }
  }
  return best;
}

Split best_of_sides(const References& items, const FrameBox& cell, float test_cost) {
  Split best;
  std::vector<float> begins(items.size()), ends(items.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (size_t i = 0; i < items.size(); ++i) begins[i] = items[i].box.lo[axis], ends[i] = items[i].box.hi[axis];
    std::sort(begins.begin(), begins.end());
    std::sort(ends.begin(), ends.end());
    for (const auto* sides : {&begins, &ends})
      for (float plane : *sides) {
        if (!(plane > cell.lo[axis] && plane < cell.hi[axis])) continue;
        size_t left = std::lower_bound(begins.begin(), begins.end(), plane) - begins.begin();
        size_t right = ends.end() - std::upper_bound(ends.begin(), ends.end(), plane);
        float cost = cost_of(cell, axis, plane, left, right, test_cost);
        if (cost < best.cost) best = {axis, plane, cost};
      }
  }
  return best;
}

Split median_of(References& items, const FrameBox& cell) {
  int axis = cell.longest_axis();
  auto middle = items.begin() + items.size() / 2;
  std::nth_element(items.begin(), middle, items.end(), [&](const Reference& a, const Reference& b) {
    float ca = a.box.centre(axis), cb = b.box.centre(axis);
    return ca < cb || (ca == cb && a.primitive < b.primitive);
  });
  float plane = middle->box.centre(axis);
  if (!(plane > cell.lo[axis] && plane < cell.hi[axis])) return {};
  return {axis, plane, 0.0f};
}

// What of the items lies in a cell, by their clipped parts.
References within(const References& items, const PrimitiveSet& primitives, const FrameBox& cell, int axis) {
  References out;
  const FrameBox padded = cell.padded(kBoxPadding);
  for (const Reference& item : items) {
    if (item.box.lo[axis] > padded.hi[axis] || item.box.hi[axis] < padded.lo[axis]) continue;
    Reference part{padded, item.primitive};
    if (item.box.lo[axis] >= padded.lo[axis] && item.box.hi[axis] <= padded.hi[axis]) {
      out.push_back(item);
    } else if (primitives.clip_to(item.primitive, part.box)) {
      out.push_back(part);
    }
  }
  return out;
}

}  // namespace

Bsp Bsp::build(const PrimitiveSet& primitives, Plane kind, std::vector<uint32_t>& order) {
  Bsp bsp;
  const float test_cost = primitives.test_cost;
  order.clear();
  std::vector<CellTask> tasks;
  tasks.push_back(CellTask::root(primitives));
  bsp.bounds_ = tasks[0].cell;
  bsp.nodes_.emplace_back();
  while (!tasks.empty()) {
    CellTask task = std::move(tasks.back());
    tasks.pop_back();
    const size_t count = task.items.size();
    Split split;
    if (task.depth < kMaxDepth && count > 0) {
      if (kind == Plane::Median) {
        if (count * test_cost > kMedianLeafCost) split = median_of(task.items, task.cell);
      } else {
        split = count > kSorted ? best_of_bins(task.items, task.cell, test_cost)
                                : best_of_sides(task.items, task.cell, test_cost);
        if (!(split.cost < test_cost * count)) split.axis = -1;
      }
    }
    if (split.axis >= 0) {
      FrameBox left_cell = task.cell, right_cell = task.cell;
      left_cell.hi[split.axis] = right_cell.lo[split.axis] = split.plane;
      References left = within(task.items, primitives, left_cell, split.axis);
      References right = within(task.items, primitives, right_cell, split.axis);
      const double sum = static_cast<double>(left.size() + right.size());
      // A median that parts nothing, and references beyond the bound, end in a leaf.
      bool parted = kind == Plane::Sah || sum < 1.6 * count;
      if (parted && sum <= task.allowed) {
        uint32_t children = static_cast<uint32_t>(bsp.nodes_.size());
        bsp.nodes_[task.node] = {split.plane, children, static_cast<uint32_t>(split.axis), 0};
        bsp.nodes_.resize(children + 2);
        double to_left = sum > 0 ? task.allowed * left.size() / sum : 0.0;
        tasks.push_back({children + 1, task.depth + 1, task.allowed - to_left, right_cell, std::move(right)});
        tasks.push_back({children, task.depth + 1, to_left, left_cell, std::move(left)});
        continue;
      }
    }
    bsp.nodes_[task.node] = {0.0f, static_cast<uint32_t>(order.size()), kLeaf, static_cast<uint32_t>(count)};
    for (const Reference& item : task.items) order.push_back(item.primitive);
  }
  bsp.nodes_.shrink_to_fit();
  order.shrink_to_fit();
  return bsp;
}

double Bsp::expected_cost(float test_cost) const {
  struct Task {
    uint32_t node;
    FrameBox cell;
  };
  std::vector<Task> tasks{{0, bounds_}};
  double sum = 0.0;
  while (!tasks.empty()) {
    Task task = tasks.back();
    tasks.pop_back();
    const Node& node = nodes_[task.node];
    double chance = double(task.cell.half_area()) / bounds_.half_area();
    sum += chance * (node.axis == kLeaf ? test_cost * node.count : 1.0);
    if (node.axis == kLeaf) continue;
    Task left{node.first, task.cell}, right{node.first + 1, task.cell};
    left.cell.hi[node.axis] = right.cell.lo[node.axis] = node.plane;
    tasks.push_back(left);
    tasks.push_back(right);
  }
  return 1.0 + sum;
}

}  // namespace tilecast
