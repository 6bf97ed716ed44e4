// Top-down building by the surface area heuristic over bins, in vectors and on several threads.
//
// Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", RT 2007; boxes as vectors of minima, and all
// three axes in one pass, as in Wald, "Fast Construction of SAH BVHs on the Intel Many Integrated Core (MIC)
// Architecture", TVCG 18(1), 2012. Triangles are counted in blocks, as they are tested.
//
// The tree depends on nothing but the boxes: what the threads join are minima and counts, and nodes are numbered by
// where they are in the tree.
#include <array>
#include <memory>

#include "accel/build_item.h"
#include "accel/bvh.h"
#include "base/parallel.h"

namespace tilecast {
namespace {

constexpr int kMostBins = 32;
constexpr uint32_t kMany = 1000, kFew = 8;  // items: more take all bins, not more a quarter of them, others half
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

struct Range {
  uint32_t first, count;
  int depth;
  Eight bounds, centres;  // joined
};

class Bins {
 public:
  explicit Bins(const Range& range)
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
      const Four32 bin = __builtin_convertvector(within((low_half(item.centre()) - lo_) * scale_), Four32);
      for (int axis = 0; axis < 3; ++axis) {
        const uint32_t b = static_cast<uint32_t>(bin[axis]);
        boxes_[axis][b] = least(boxes_[axis][b], item.lanes);
        ++counts_[b][axis];
      }
    }
  }
  void add(const Bins& other) {
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

  // Moves what lies left of the split to the front; the ranges get all but their depth. Each item trades places with
  // the first of the right side, wherever it belongs, so that nothing has to be foreseen.
  void part(BuildItem* items, const Range& range, const Split& split, Range& left, Range& right) const {
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
  static Four within(Four place) {  // the array; nothing else is expected, but would be written through
    place = place > 0.0f ? place : Four{};
    return place < kMostBins - 1.0f ? place : Four{} + (kMostBins - 1.0f);
  }

  const int bins_;
  Four lo_{}, scale_{};
  Eight boxes_[3][kMostBins];
  Four32 counts_[kMostBins];
};

// The joined boxes and centres of a range's items.
void measure(const BuildItem* items, Range& range) {
  range.bounds = range.centres = kNothing;
  for (const BuildItem *i = items + range.first, *end = i + range.count; i < end; ++i) {
    range.bounds = least(range.bounds, i->lanes);
    range.centres = least(range.centres, i->centre());
  }
}

class Builder {
 public:
  using Node = Bvh::Node;

  Builder(const PrimitiveSet& primitives, int threads)
      : threads_(threads),
        test_cost_(primitives.test_cost),
        in_blocks_(primitives.tested_together() > 1),
        items_(new BuildItem[primitives.size()]) {
    const uint32_t count = static_cast<uint32_t>(primitives.size());
    root_ = {0, count, 0, kNothing, kNothing};
    std::vector<Range> parts = stretches(root_);
    in_parallel(threads_, parts.size(), [&](size_t i) {
      for (uint32_t k = parts[i].first; k < parts[i].first + parts[i].count; ++k)
        items_[k] = BuildItem::of(primitives.boxes[k], k);
      measure(items_.get(), parts[i]);
    });
    for (const Range& part : parts) {
      root_.bounds = least(root_.bounds, part.bounds);
      root_.centres = least(root_.centres, part.centres);
    }
  }

  // The upper levels one after the other, breadth first; then what is left, by subtrees.
  std::vector<Node> build() {
    std::vector<Node> nodes(1);
    struct Open {
      uint32_t node;
      Range range;
    };
    std::vector<Open> level{{0, root_}}, below, alone;
    while (!level.empty()) {
      std::vector<std::array<Range, 2>> parts(level.size());
      std::vector<uint8_t> inner(level.size());
      auto part_one = [&](size_t i, int threads) {
        const Range& range = level[i].range;
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
  static std::vector<Range> stretches(const Range& range) {
    std::vector<Range> out;
    for (uint32_t done = 0; done < range.count; done += kStretch)
      out.push_back({range.first + done, std::min(kStretch, range.count - done), 0, kNothing, kNothing});
    return out;
  }

  static Node node_of(const Range& range, uint32_t first, uint32_t count) {
    Node node;
    node.set_box(box_of(range.bounds));
    node.first = first;
    node.count = count;
    return node;
  }

  Bins bin(const Range& range, int threads) const {
    Bins bins(range);
    if (threads == 1 || range.count <= 2 * kStretch) {
      bins.add(items_.get() + range.first, range.count);
      return bins;
    }
    std::mutex mutex;
    const std::vector<Range> parts = stretches(range);
    in_parallel(threads, parts.size(), [&](size_t i) {
      Bins some(range);
      some.add(items_.get() + parts[i].first, parts[i].count);
      std::lock_guard lock(mutex);
      bins.add(some);
    });
    return bins;
  }

  // False: a leaf.
  bool part(const Range& range, int threads, Range& left, Range& right) const {
    const uint32_t most = in_blocks_ ? kTriangleBlock : Bvh::kLeafSize;
    if (range.count <= (in_blocks_ ? kFull : 1u)) return false;
    bool halved = range.depth >= Bvh::kGroupingDepth;
    if (halved && range.count <= most) return false;
    if (!halved) {
      const Bins bins = bin(range, threads);
      const Bins::Split split = in_blocks_ ? bins.best_split(cost_in_blocks) : bins.best_split(cost_alone);
      if (range.count <= most) {
        const float area = box_of(range.bounds).half_area();
        const bool worth = in_blocks_ ? split.cost < kDoubt * area
                                      : 1.0f + test_cost_ * split.cost / area < test_cost_ * range.count;
        if (!worth) return false;
      }
      halved = split.axis < 0;
      if (!halved) bins.part(items_.get(), range, split, left, right);
      halved = halved || left.count == 0 || right.count == 0;
    }
    if (halved) {
      left.first = range.first, left.count = range.count / 2;
      right.first = range.first + left.count, right.count = range.count - left.count;
      measure(items_.get(), left);
      measure(items_.get(), right);
    }
    left.depth = right.depth = range.depth + 1;
    return true;
  }

  std::vector<Node> subtree(const Range& range) const {
    struct Open {
      uint32_t node;
      Range range;
    };
    std::vector<Node> nodes(1);
    nodes.reserve(in_blocks_ ? range.count : 2 * range.count);
    std::vector<Open> open{{0, range}};
    while (!open.empty()) {
      const Open at = open.back();
      open.pop_back();
      Range left, right;
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
    return nodes;
  }

  const int threads_;
  const float test_cost_;
  const bool in_blocks_;
  const std::unique_ptr<BuildItem[]> items_;
  Range root_;
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
