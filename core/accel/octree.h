// An octree: eight children a node, by three planes. What a plane cuts stands on both sides.
//
// Even: the planes halve the cell (Glassner, "Space Subdivision for Fast Ray Tracing", 1984). Balanced: they stand at
// the medians of the objects (compare Whang et al., "Octree-R", 1995).
#pragma once

#include <vector>

#include "accel/traversal.h"

namespace tilecast {

class Octree {
 public:
  static constexpr int kMaxDepth = 20;
  static constexpr uint32_t kInner = ~0u;
  struct Node {  // 20 bytes; children stand side by side, child c on the upper side of axis i where bit i of c is set
    float planes[3] = {};
    uint32_t first = 0;  // of the children, or of the leaf's references
    uint32_t count = 0;  // of the leaf's references; kInner: an inner node
  };
  enum class Planes : uint8_t { Even, Balanced };

  // `order` receives the references of the leaves.
  static Octree build(const PrimitiveSet& primitives, Planes planes, std::vector<uint32_t>& order);

  size_t node_count() const { return nodes_.size(); }
  uint64_t bytes() const { return nodes_.size() * sizeof(Node); }
  double expected_cost(float test_cost) const;

  // Calls leaf(first, count) for the leaves that the ray passes in [s_min, s_max], in order; see Bvh::traverse.
  template <class Cost, class Leaf>
  bool traverse(const FrameRay& ray, float s_min, const float& s_max, Cost& cost, Leaf&& leaf) const {
    struct Entry {
      uint32_t node;
      float s_in, s_out;
    };
    Entry stack[3 * kMaxDepth + 4];
    int top = 0;
    cost.step();
    float entry = enter(bounds_.lo, bounds_.hi, ray, s_min, s_max);
    if (entry == kMissed) return false;
    stack[top++] = {0, entry, s_max};
    unsigned backward = 0;  // axes on which the upper side comes first
    for (int i = 0; i < 3; ++i) backward |= unsigned(std::signbit(ray.reciprocal[i])) << i;
    while (top > 0) {
      Entry current = stack[--top];
      if (current.s_in > s_max) return false;  // all others are farther
      const Node& node = nodes_[current.node];
      if (node.count != kInner) {
        if (node.count > 0 && leaf(node.first, node.count)) return true;
        continue;
      }
      // The child at s_in, then one more for each plane that is crossed before s_out: at most four.
      unsigned child = backward;
      float at[3];
      int axes[3], crossed = 0;
      for (int i = 0; i < 3; ++i) {
        at[i] = crossing(ray, i, node.planes[i]);
        if (at[i] < current.s_in) {
          child ^= 1u << i;
        } else if (at[i] <= current.s_out) {
          int k = crossed++;
          for (; k > 0 && at[axes[k - 1]] > at[i]; --k) axes[k] = axes[k - 1];
          axes[k] = i;
        }
      }
      cost.step(1 + crossed);
      Entry passed[4];
      for (int k = 0; k <= crossed; ++k) {
        passed[k] = {node.first + child, k == 0 ? current.s_in : at[axes[k - 1]],
                     k == crossed ? current.s_out : at[axes[k]]};
        if (k < crossed) child ^= 1u << axes[k];
      }
      for (int k = crossed; k >= 0; --k)
        if (nodes_[passed[k].node].count != 0) stack[top++] = passed[k];
    }
    return false;
  }

 private:
  FrameBox bounds_;
  std::vector<Node> nodes_;
};

}  // namespace tilecast
