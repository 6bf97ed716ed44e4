// Top-down building by the surface area heuristic over bins, in vectors and on several threads.
//
// Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", RT 2007. Triangles are counted in blocks, as
// they are tested.
//
// The tree depends on nothing but the boxes: what the threads join are minima and counts, and nodes are numbered by
// where they are in the tree.
#include <array>

#include "accel/build_bins.h"
#include "accel/bvh.h"
#include "base/large_array.h"
#include "base/parallel.h"

namespace tilecast {
namespace {

constexpr uint32_t kAlone = 1 << 12;    // a subtree of so many items is built by one thread
constexpr uint32_t kStretch = 1 << 14;  // of items, that a thread bins

// A block of more triangles than kFull is parted where its parts' expected cost is below kDoubt of its own: folding
// decides whether it pays. (Where triangles lie far apart, it does.)
constexpr uint32_t kFull = 5;
constexpr float kDoubt = 1.2f;

Four cost_alone(Four32 count) { return __builtin_convertvector(count, Four); }
// In blocks: in whole ones, as they are tested, but half of it in proportion, as what is parted again will be.
Four cost_in_blocks(Four32 count) {
  static_assert(kTriangleBlock == 8);
  return 0.5f * __builtin_convertvector((count + 7) >> 3, Four) + 0.0625f * __builtin_convertvector(count, Four);
}

class Builder {
 public:
  using Node = Bvh::Node;

  Builder(const PrimitiveSet& primitives, int threads)
      : threads_(threads),
        test_cost_(primitives.test_cost),
        in_blocks_(primitives.tested_together() > 1),
        items_(primitives.size()) {
    const uint32_t count = static_cast<uint32_t>(primitives.size());
    root_ = {0, count, 0, kNothing, kNothing};
    std::vector<BuildRange> parts = stretches(root_);
    in_parallel(threads_, parts.size(), [&](size_t i) {
      for (uint32_t k = parts[i].first; k < parts[i].first + parts[i].count; ++k)
        items_[k] = BuildItem::of(primitives.boxes[k], k);
      measure(items_.data(), parts[i]);
    });
    for (const BuildRange& part : parts) {
      root_.bounds = least(root_.bounds, part.bounds);
      root_.centres = least(root_.centres, part.centres);
    }
  }

  // The upper levels one after the other, breadth first; then what is left, by subtrees.
  std::vector<Node> build() {
    std::vector<Node> nodes(1);
    struct Open {
      uint32_t node;
      BuildRange range;
    };
    std::vector<Open> level{{0, root_}}, below, alone;
    while (!level.empty()) {
      std::vector<std::array<BuildRange, 2>> parts(level.size());
      std::vector<uint8_t> inner(level.size());
      auto part_one = [&](size_t i, int threads) {
        const BuildRange& range = level[i].range;
        inner[i] = range.count > kAlone && part(range, threads, parts[i][0], parts[i][1]);
      };
      const bool few = level.size() < 4u * static_cast<unsigned>(threads_);
      if (few) {
        for (size_t i = 0; i < level.size(); ++i) part_one(i, threads_);
      } else {
        in_parallel(threads_, level.size(), [&](size_t i) { part_one(i, 1); });
      }
      below.clear();
      for (size_t i = 0; i < level.size(); ++i) {
        if (!inner[i]) {
          alone.push_back(level[i]);
          continue;
        }
        const uint32_t children = static_cast<uint32_t>(nodes.size());
        nodes[level[i].node] = node_of(level[i].range, children, 0);
        nodes.resize(children + 2);
        below.push_back({children, parts[i][0]});
        below.push_back({children + 1, parts[i][1]});
      }
      std::swap(level, below);
    }
    std::vector<std::vector<Node>> subtrees(alone.size());
    in_parallel(threads_, alone.size(), [&](size_t i) { subtrees[i] = subtree(alone[i].range); });
    size_t total = nodes.size();
    for (const auto& subtree : subtrees) total += subtree.size() - 1;
    nodes.reserve(total);
    for (size_t i = 0; i < alone.size(); ++i) {
      const uint32_t shift = static_cast<uint32_t>(nodes.size()) - 1;  // the subtree's root stands above already
      auto moved = [&](Node node) {
        if (node.count == 0) node.first += shift;
        return node;
      };
      nodes[alone[i].node] = moved(subtrees[i][0]);
      for (size_t k = 1; k < subtrees[i].size(); ++k) nodes.push_back(moved(subtrees[i][k]));
      subtrees[i] = {};
    }
    return nodes;
  }

  void write_order(std::vector<uint32_t>& order) const {
    order.resize(root_.count);
    for (uint32_t i = 0; i < root_.count; ++i) order[i] = items_[i].primitive();
  }

 private:
  static std::vector<BuildRange> stretches(const BuildRange& range) {
    std::vector<BuildRange> out;
    for (uint32_t done = 0; done < range.count; done += kStretch)
      out.push_back({range.first + done, std::min(kStretch, range.count - done), 0, kNothing, kNothing});
    return out;
  }

  static Node node_of(const BuildRange& range, uint32_t first, uint32_t count) {
    Node node;
    node.set_box(box_of(range.bounds));
    node.first = first;
    node.count = count;
    return node;
  }

  BuildBins bin(const BuildRange& range, int threads) const {
    BuildBins bins(range);
    if (threads == 1 || range.count <= 2 * kStretch) {
      bins.add(items_.data() + range.first, range.count);
      return bins;
    }
    std::mutex mutex;
    const std::vector<BuildRange> parts = stretches(range);
    in_parallel(threads, parts.size(), [&](size_t i) {
      BuildBins some(range);
      some.add(items_.data() + parts[i].first, parts[i].count);
      std::lock_guard lock(mutex);
      bins.add(some);
    });
    return bins;
  }

  // False: a leaf.
  bool part(const BuildRange& range, int threads, BuildRange& left, BuildRange& right) {
    const uint32_t most = in_blocks_ ? kTriangleBlock : Bvh::kLeafSize;
    if (range.count <= (in_blocks_ ? kFull : 1u)) return false;
    bool halved = range.depth >= Bvh::kGroupingDepth;
    if (halved && range.count <= most) return false;
    if (!halved) {
      const BuildBins bins = bin(range, threads);
      const BuildBins::Split split = in_blocks_ ? bins.best_split(cost_in_blocks) : bins.best_split(cost_alone);
      if (range.count <= most) {
        const float area = box_of(range.bounds).half_area();
        const bool worth = in_blocks_ ? split.cost < kDoubt * area
                                      : 1.0f + test_cost_ * split.cost / area < test_cost_ * range.count;
        if (!worth) return false;
      }
      halved = split.axis < 0;
      if (!halved) bins.part(items_.data(), range, split, left, right);
      halved = halved || left.count == 0 || right.count == 0;
    }
    if (halved) {
      left.first = range.first, left.count = range.count / 2;
      right.first = range.first + left.count, right.count = range.count - left.count;
      measure(items_.data(), left);
      measure(items_.data(), right);
    }
    left.depth = right.depth = range.depth + 1;
    return true;
  }

  std::vector<Node> subtree(const BuildRange& range) {
    struct Open {
      uint32_t node;
      BuildRange range;
    };
    std::vector<Node> nodes(1);
    nodes.reserve(in_blocks_ ? range.count : 2 * range.count);
    std::vector<Open> open{{0, range}};
    while (!open.empty()) {
      const Open at = open.back();
      open.pop_back();
      BuildRange left, right;
      if (!part(at.range, 1, left, right)) {
        nodes[at.node] = node_of(at.range, at.range.first, at.range.count);
        continue;
      }
      const uint32_t children = static_cast<uint32_t>(nodes.size());
      nodes[at.node] = node_of(at.range, children, 0);
      nodes.resize(children + 2);
      open.push_back({children + 1, right});
      open.push_back({children, left});
    }
    return std::vector<Node>(nodes.begin(), nodes.end());  // without what was reserved
  }

  const int threads_;
  const float test_cost_;
  const bool in_blocks_;
  LargeArray<BuildItem> items_;
  BuildRange root_;
};

}  // namespace

Bvh Bvh::build_binned(const PrimitiveSet& primitives, std::vector<uint32_t>& order, int threads) {
  Builder builder(primitives, std::max(threads, 1));
  Bvh bvh;
  bvh.nodes_ = builder.build();
  builder.write_order(order);
  return bvh;
}

}  // namespace tilecast
