// A bounding volume hierarchy over float boxes in a frame, two children a node.
//
// The builders differ in what they group (accel/binned_build.cpp, bvh_build.cpp) and may be followed
// by an optimisation (accel/reinsertion.cpp). All bound the depth, so the traversal's stack is fixed.
#pragma once

#include <vector>

#include "accel/traversal.h"

namespace tilecast {

// How a node's primitives are parted in two.
enum class Grouping : uint8_t {
  Sah,       // surface area heuristic over bins (Wald 2007)
  SahSweep,  // surface area heuristic over every place between two centroids (MacDonald and Booth 1990)
  Median,    // as many on each side (Kay and Kajiya 1986)
  Middle,    // at the middle of the centroids' longest extent
  Morton,    // along a space-filling curve (Lauterbach et al. 2009)
};

class Bvh {
 public:
  struct Node {  // 32 bytes; children stand side by side
    float lo[3];
    uint32_t first;  // of the children, or of the leaf's references
    float hi[3];
    uint32_t count;  // of the leaf's references; 0: an inner node

    FrameBox box() const { return {{lo[0], lo[1], lo[2]}, {hi[0], hi[1], hi[2]}}; }
    void set_box(const FrameBox& box) { std::copy_n(box.lo, 3, lo), std::copy_n(box.hi, 3, hi); }
  };
  static constexpr int kMaxDepth = 72;
  static constexpr int kGroupingDepth = 38;  // nodes below are halved by index: at most 32 levels more
  static constexpr uint32_t kLeafSize = 4;   // at most; of triangles that Sah groups: kTriangleBlock

  // `order` receives the primitives in the order of the leaves. Sah builds on several threads; the tree is the same for
  // any number of them.
  static Bvh build(const PrimitiveSet& primitives, Grouping grouping, std::vector<uint32_t>& order,
                   int threads = 1);
  // With objects in more than one box; `order` has at most `most_references` entries.
  static Bvh build_with_spatial_splits(const PrimitiveSet& primitives, size_t most_references, std::vector<uint32_t>& order,
                                       int threads = 1);
  // Takes nodes out and puts them where they cost least, as long as that pays.
  void optimise_by_reinsertion();

  const std::vector<Node>& nodes() const { return nodes_; }
  size_t node_count() const { return nodes_.size(); }
  uint64_t bytes() const { return nodes_.size() * sizeof(Node); }
  // Steps and tests (at test_cost, of so many primitives at once) that a line through the root is expected to cost.
  double expected_cost(float test_cost, uint32_t together = 1) const;
  // Of it, what is spent where siblings' boxes overlap: about what spatial splits may save.
  double overlap_cost(float test_cost, uint32_t together = 1) const;

  // Calls leaf(first, count) for every leaf whose box meets the ray in [s_min, s_max], near ones first; the leaf may
  // lower s_max, and ends the traversal by returning true. Only strictly farther boxes are culled.
  template <class Cost, class Leaf>
  bool traverse(const FrameRay& ray, float s_min, const float& s_max, Cost& cost, Leaf&& leaf) const {
    struct Entry {
      uint32_t node;
      float s;
    };
    Entry stack[kMaxDepth];
    int top = 0;
    cost.step();
    if (enter(nodes_[0].lo, nodes_[0].hi, ray, s_min, s_max) == kMissed) return false;
    uint32_t current = 0;
    for (;;) {
      const Node& node = nodes_[current];
      if (node.count > 0) {
        if (leaf(node.first, node.count)) return true;
      } else {
        const Node *l = &nodes_[node.first], *r = l + 1;
        cost.step(2);
        float left = enter(l->lo, l->hi, ray, s_min, s_max);
        float right = enter(r->lo, r->hi, ray, s_min, s_max);
        if (left != kMissed && right != kMissed) {
          bool left_first = left <= right;
          stack[top++] = left_first ? Entry{node.first + 1, right} : Entry{node.first, left};
          current = node.first + (left_first ? 0 : 1);
          continue;
        }
        if (left != kMissed || right != kMissed) {
          current = node.first + (left != kMissed ? 0 : 1);
          continue;
        }
      }
      do {
        if (top == 0) return false;
        --top;
      } while (stack[top].s > s_max);
      current = stack[top].node;
    }
  }

  // The same, strictly in the order of the boxes' entries; leaf(first, count, s) learns at which s the ray enters.
  // `open` keeps what is still to be entered, as a heap.
  struct Pending {
    float s;
    uint32_t node;
    bool operator<(const Pending& other) const { return s > other.s; }  // the nearest on top of std::push_heap's heap
  };
  template <class Leaf>
  void traverse_in_order(const FrameRay& ray, float s_min, float s_max, std::vector<Pending>& open, Leaf&& leaf) const {
    open.clear();
    auto add = [&](uint32_t node) {
      float s = enter(nodes_[node].lo, nodes_[node].hi, ray, s_min, s_max);
      if (s == kMissed) return;
      open.push_back({s, node});
      std::push_heap(open.begin(), open.end());
    };
    add(0);
    while (!open.empty()) {
      Pending next = open.front();
      std::pop_heap(open.begin(), open.end());
      open.pop_back();
      const Node& node = nodes_[next.node];
      if (node.count > 0) {
        if (leaf(node.first, node.count, next.s)) return;
      } else {
        add(node.first);
        add(node.first + 1);
      }
    }
  }

 private:
  static double step_cost(const Node& node, float test_cost, uint32_t together) {  // of having met it
    return node.count > 0 ? test_cost * ((node.count + together - 1) / together) : 2.0;
  }
  int depth() const;

  std::vector<Node> nodes_;
};

}  // namespace tilecast
