// A bounding volume hierarchy over float boxes in a frame, two children a node.
//
// Built by binned surface area heuristic (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007);
// split by index where boxes cannot be told apart. The depth is bounded by the builder, so the stack is fixed.
#pragma once

#include <span>
#include <vector>

#include "base/frame.h"

namespace tilecast {

// A box in frame coordinates, padded by kBoxPadding and rounded outwards.
struct FrameBox {
  float lo[3], hi[3];

  static FrameBox around(const Frame& frame, const Box& box);
};

class Bvh {
 public:
  struct Node {  // 32 bytes; children stand side by side
    float lo[3];
    uint32_t first;  // of the children, or of the leaf's primitives
    float hi[3];
    uint32_t count;  // of the leaf's primitives; 0: an inner node
  };
  static constexpr int kMaxDepth = 72;

  // `order` receives the primitives in the order of the leaves. test_cost: of a primitive, in steps to a child.
  static Bvh build(std::span<const FrameBox> boxes, float test_cost, std::vector<uint32_t>& order);

  const std::vector<Node>& nodes() const { return nodes_; }

  // Calls leaf(first, count) for every leaf whose box meets the ray in [s_min, s_max], near ones first; the leaf may
  // lower s_max, and ends the traversal by returning true. Only strictly farther boxes are culled.
  template <class Leaf>
  bool traverse(const FrameRay& ray, float s_min, const float& s_max, Leaf&& leaf) const {
    struct Entry {
      uint32_t node;
      float s;
    };
    Entry stack[kMaxDepth];
    int top = 0;
    float s = enter(nodes_[0], ray, s_min, s_max);
    if (s == kMiss) return false;
    uint32_t current = 0;
    for (;;) {
      const Node& node = nodes_[current];
      if (node.count > 0) {
        if (leaf(node.first, node.count)) return true;
      } else {
        float left = enter(nodes_[node.first], ray, s_min, s_max);
        float right = enter(nodes_[node.first + 1], ray, s_min, s_max);
        if (left != kMiss && right != kMiss) {
          bool left_first = left <= right;
          stack[top++] = left_first ? Entry{node.first + 1, right} : Entry{node.first, left};
          current = node.first + (left_first ? 0 : 1);
          continue;
        }
        if (left != kMiss || right != kMiss) {
          current = node.first + (left != kMiss ? 0 : 1);
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

 private:
  static constexpr float kMiss = std::numeric_limits<float>::infinity();

  // The parameter at which the ray enters the box. The reciprocals are finite and so are all products.
  static float enter(const Node& node, const FrameRay& ray, float s_min, float s_max) {
    float near = s_min, far = s_max;
    for (int i = 0; i < 3; ++i) {
      float a = (node.lo[i] - ray.origin[i]) * ray.reciprocal[i];
      float b = (node.hi[i] - ray.origin[i]) * ray.reciprocal[i];
      near = std::max(near, std::min(a, b));
      far = std::min(far, std::max(a, b));
    }
    return near <= far ? near : kMiss;
  }

  std::vector<Node> nodes_;
};

}  // namespace tilecast
