#include "accel/octree.h"

#include "accel/reference.h"

namespace tilecast {
namespace {

constexpr float kLeafCost = 6.0f;       // of the tests in a leaf that is worth no more nodes
constexpr double kNothingParted = 4.0;  // children's references for each of the node's: splitting on is no use

FrameBox child_cell(const FrameBox& cell, const float planes[3], unsigned child) {
  FrameBox out = cell;
  for (int i = 0; i < 3; ++i) (child >> i & 1 ? out.lo : out.hi)[i] = planes[i];
  return out;
}

float median(const References& items, int axis) {
  std::vector<float> centres(items.size());
  for (size_t i = 0; i < items.size(); ++i) centres[i] = items[i].box.centre(axis);
  std::nth_element(centres.begin(), centres.begin() + centres.size() / 2, centres.end());
  return centres[centres.size() / 2];
}

bool overlap(const FrameBox& a, const FrameBox& b) { return !a.intersected(b).empty(); }

}  // namespace

Octree Octree::build(const PrimitiveSet& primitives, Planes kind, std::vector<uint32_t>& order) {
  Octree octree;
  order.clear();
  std::vector<CellTask> tasks;
  tasks.push_back(CellTask::root(primitives));
  octree.bounds_ = tasks[0].cell;
  octree.nodes_.emplace_back();
  while (!tasks.empty()) {
    CellTask task = std::move(tasks.back());
    tasks.pop_back();
    const size_t count = task.items.size();
    Node node;
    bool inner = task.depth < kMaxDepth && count * primitives.test_cost > kLeafCost;
    References children[8];
    size_t sum = 0;
    if (inner) {
      for (int i = 0; i < 3; ++i) {
        node.planes[i] = kind == Planes::Even ? task.cell.centre(i) : median(task.items, i);
        node.planes[i] = std::clamp(node.planes[i], task.cell.lo[i], task.cell.hi[i]);
      }
      for (unsigned c = 0; c < 8; ++c) {
        const FrameBox padded = child_cell(task.cell, node.planes, c).padded(kBoxPadding);
        for (const Reference& item : task.items) {
          if (!overlap(item.box, padded)) continue;
          Reference part{padded, item.primitive};
          if (primitives.clip_to(item.primitive, part.box)) children[c].push_back(part);
        }
        sum += children[c].size();
      }
      inner = sum < kNothingParted * count && sum <= task.allowed;
    }
    if (!inner) {
      node.first = static_cast<uint32_t>(order.size());
      node.count = static_cast<uint32_t>(count);
      octree.nodes_[task.node] = node;
      for (const Reference& item : task.items) order.push_back(item.primitive);
      continue;
    }
    node.first = static_cast<uint32_t>(octree.nodes_.size());
    node.count = kInner;
    octree.nodes_[task.node] = node;
    octree.nodes_.resize(node.first + 8);
    for (unsigned c = 8; c-- > 0;) {
      double allowed = task.allowed * children[c].size() / std::max<size_t>(sum, 1);
      tasks.push_back({node.first + c, task.depth + 1, allowed, child_cell(task.cell, node.planes, c),
                       std::move(children[c])});
    }
  }
  octree.nodes_.shrink_to_fit();
  order.shrink_to_fit();
  return octree;
}

double Octree::expected_cost(float test_cost) const {
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
    sum += chance * (1.0 + (node.count == kInner ? 0.0 : test_cost * node.count));
    if (node.count != kInner) continue;
    for (unsigned c = 0; c < 8; ++c) tasks.push_back({node.first + c, child_cell(task.cell, node.planes, c)});
  }
  return sum;
}

}  // namespace tilecast
