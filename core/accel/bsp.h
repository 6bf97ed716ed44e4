// A binary space partition by axis-parallel planes (a k-d tree). What a plane cuts stands on both sides.
//
// Sah: planes by the surface area heuristic (MacDonald and Booth, "Heuristics for Ray Tracing Using Space Subdivision",
// 1990; candidates as in Wald and Havran, "On building fast kd-Trees for Ray Tracing", RT 2006, and by bins where a
// node is large: Shevtsov et al. 2007). Median: at the median of the objects (Kay and Kajiya's and the lecture's
// "groups of equal size").
#pragma once

#include <vector>

#include "accel/traversal.h"

namespace tilecast {

class Bsp {
 public:
  static constexpr uint32_t kLeaf = 3;
  static constexpr int kMaxDepth = 48;
  struct Node {  // 12 bytes; children stand side by side
    float plane;
    uint32_t first;       // of the children, or of the leaf's references
    uint32_t axis : 2;    // kLeaf: a leaf
    uint32_t count : 30;  // of its references
  };
  enum class Plane : uint8_t { Sah, Median };

  // `order` receives the references of the leaves.
  static Bsp build(const PrimitiveSet& primitives, Plane plane, std::vector<uint32_t>& order);

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
    Entry stack[kMaxDepth];
    int top = 0;
    cost.step();
    float s_in = enter(bounds_.lo, bounds_.hi, ray, s_min, s_max), s_out = s_max;
    if (s_in == kMissed) return false;
    uint32_t current = 0;
    for (;;) {
      const Node& node = nodes_[current];
      if (node.axis != kLeaf) {
        cost.step();
        // A point at s lies before the plane while s <= at, and behind it from s >= at on.
        float at = crossing(ray, node.axis, node.plane);
        uint32_t near = node.first, far = node.first + 1;
        if (std::signbit(ray.reciprocal[node.axis])) std::swap(near, far);
        if (at > s_out) {
          current = near;
        } else if (at < s_in) {
          current = far;
        } else {
          stack[top++] = {far, at, s_out};
          current = near;
          s_out = at;
        }
        continue;
      }
      if (node.count > 0 && leaf(node.first, node.count)) return true;
      if (top == 0) return false;
      --top;
      if (stack[top].s_in > s_max) return false;  // all others are farther
      current = stack[top].node, s_in = stack[top].s_in, s_out = stack[top].s_out;
    }
  }

 private:
  FrameBox bounds_;
  std::vector<Node> nodes_;
};

}  // namespace tilecast
