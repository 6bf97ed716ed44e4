// Top-down building by the surface area heuristic over bins, in vectors and on several threads; where the boxes of the best
// split overlap, planes that cut items are tried as well, as long as there is room for more of them.
//
// Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", RT 2007. Triangles are counted in blocks, as
// they are tested.
//
// The tree depends on nothing but the boxes: what the threads join are minima and counts, and nodes are numbered by
// where they are in the tree.
#include <array>

#include "accel/build_bins.h"
#include "accel/bvh.h"
#include "accel/plane_bins.h"
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

// A plane is tried where the sides of the best split overlap by so much of their node's surface. The more they do, the more a
// plane may cost, of what the split does: what overlaps is paid for again further down, which the heuristic does not see.
// (Soup: 0.25 and 0.75 give 7 % more references, the least expected cost, and 0.36 million triangles a second; tried from
// 0.2 on, 0.22 million at the same cost.)
constexpr float kSpatialOverlap = 0.25f;
float most_cost(float overlap) { return std::min(0.75f + 0.75f * overlap, 1.1f); }

Four cost_alone(Four32 count) { return __builtin_convertvector(count, Four); }
// In blocks: in whole ones, as they are tested, but half of it in proportion, as what is parted again will be.
Four cost_in_blocks(Four32 count) {
  static_assert(kTriangleBlock == 8);
  return 0.5f * __builtin_convertvector((count + 7) >> 3, Four) + 0.0625f * __builtin_convertvector(count, Four);
}

class Builder {
 public:
  using Node = Bvh::Node;

  // most: items, of which some stand in several places where it is more than there are primitives.
  Builder(const PrimitiveSet& primitives, uint32_t most, int threads)
      : primitives_(primitives),
        threads_(threads),
        test_cost_(primitives.test_cost),
        in_blocks_(primitives.tested_together() > 1),
        items_(most) {
    const uint32_t count = static_cast<uint32_t>(primitives.size());
    root_ = {0, count, most, 0, kNothing, kNothing};
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

  // The primitives in the order of the leaves, which then count from the first of it.
  void write_order(std::vector<Node>& nodes, std::vector<uint32_t>& order) const {
    order.clear();
    order.reserve(root_.count);
    if (items_.size() == root_.count) {
      for (const BuildItem& item : items_) order.push_back(item.primitive());
      return;
    }
    for (Node& node : nodes) {
      if (node.count == 0) continue;
      const BuildItem* items = items_.data() + node.first;
      node.first = static_cast<uint32_t>(order.size());
      for (uint32_t i = 0; i < node.count; ++i) order.push_back(items[i].primitive());
    }
    order.shrink_to_fit();
  }

 private:
  static std::vector<BuildRange> stretches(const BuildRange& range) {
    std::vector<BuildRange> out;
    for (uint32_t done = 0; done < range.count; done += kStretch)
      out.push_back({range.first + done, std::min(kStretch, range.count - done), 0, 0, kNothing, kNothing});
    return out;
  }

  static Node node_of(const BuildRange& range, uint32_t first, uint32_t count) {
    Node node;
    node.set_box(box_of(range.bounds));
    node.first = first;
    node.count = count;
    return node;
  }

  // The bins that make() gives, with the range's items.
  template <class Make>
  auto bin(const BuildRange& range, int threads, Make&& make) const {
    auto bins = make();
    if (threads == 1 || range.count <= 2 * kStretch) {
      bins.add(items_.data() + range.first, range.count);
      return bins;
    }
    std::mutex mutex;
    const std::vector<BuildRange> parts = stretches(range);
    in_parallel(threads, parts.size(), [&](size_t i) {
      auto some = make();
      some.add(items_.data() + parts[i].first, parts[i].count);
      std::lock_guard lock(mutex);
      bins.add(some);
    });
    return bins;
  }

  template <class Bins, class... Limits>
  typename Bins::Split best_split(const Bins& bins, Limits... limits) const {
    return in_blocks_ ? bins.best_split(limits..., cost_in_blocks) : bins.best_split(limits..., cost_alone);
  }

  // False: a leaf.
  bool part(const BuildRange& range, int threads, BuildRange& left, BuildRange& right) {
    const uint32_t most = in_blocks_ ? kTriangleBlock : Bvh::kLeafSize;
    if (range.count <= (in_blocks_ ? kFull : 1u)) return false;
    bool halved = range.depth >= Bvh::kGroupingDepth;
    if (halved && range.count <= most) return false;
    if (!halved) {
      const float area = box_of(range.bounds).half_area();
      const BuildBins bins = bin(range, threads, [&] { return BuildBins(range); });
      const BuildBins::Split split = best_split(bins);
      if (range.count <= most) {
        const bool worth = in_blocks_ ? split.cost < kDoubt * area
                                      : 1.0f + test_cost_ * split.cost / area < test_cost_ * range.count;
        if (!worth) return false;
      }
      const bool cut = range.count > most && part_at_plane(range, threads, area, bins, split, left, right);
      halved = !cut && split.axis < 0;
      if (!cut && !halved) bins.part(items_.data(), range, split, left, right);
      halved = halved || left.count == 0 || right.count == 0;
    }
    if (halved) {
      left.first = range.first, left.count = range.count / 2;
      right.first = range.first + left.count, right.count = range.count - left.count;
      measure(items_.data(), left);
      measure(items_.data(), right);
    }
    left.depth = right.depth = range.depth + 1;
    share_room(range, left, right);
    return true;
  }

  // False: there is no plane that is worth it.
  bool part_at_plane(const BuildRange& range, int threads, float area, const BuildBins& bins, const BuildBins::Split& split,
                     BuildRange& left, BuildRange& right) {
    const uint32_t room = range.end - range.first - range.count;
    if (room == 0 || split.axis < 0) return false;  // what lies at one place would, cut, do so again
    const float overlap = bins.overlap(split);
    if (overlap < kSpatialOverlap * area) return false;
    const PlaneBins planes = bin(range, threads, [&] { return PlaneBins(range, primitives_); });
    const PlaneBins::Split plane = best_split(planes, range.count, room);
    return plane.cost < most_cost(overlap / area) * split.cost &&
           PlaneBins::part(primitives_, items_.data(), range, plane, left, right);
  }

  // Gives both parts of the room that is left in proportion.
  void share_room(const BuildRange& range, BuildRange& left, BuildRange& right) {
    const uint32_t end = right.first + right.count;
    const uint32_t to_left = static_cast<uint32_t>(uint64_t(range.end - end) * left.count / (left.count + right.count));
    if (to_left > 0)
      std::copy_backward(items_.begin() + right.first, items_.begin() + end, items_.begin() + end + to_left);
    right.first += to_left;
    left.end = right.first;
    right.end = range.end;
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

  const PrimitiveSet& primitives_;
  const int threads_;
  const float test_cost_;
  const bool in_blocks_;
  LargeArray<BuildItem> items_;
  BuildRange root_;
};

}  // namespace

Bvh Bvh::build_with_spatial_splits(const PrimitiveSet& primitives, size_t most_references, std::vector<uint32_t>& order,
                                   int threads) {
  Builder builder(primitives, static_cast<uint32_t>(std::max(most_references, primitives.size())), std::max(threads, 1));
  Bvh bvh;
  bvh.nodes_ = builder.build();
  builder.write_order(bvh.nodes_, order);
  return bvh;
}

}  // namespace tilecast
