// A bounding volume hierarchy over boxes, eight children a node, whose boxes are looked at together: what a group's
// instances are found by. Folded out of a binary one, it has a box for each primitive even where that has leaves of many.
#pragma once

#include <bit>
#include <cstring>

#include "accel/box_lanes.h"
#include "accel/bvh.h"

namespace tilecast {

class WideBoxes {
 public:
  // `order`: the primitives in the order of the hierarchy's leaves; `boxes`: of each primitive.
  static WideBoxes fold(const Bvh& bvh, const std::vector<uint32_t>& order, std::span<const FrameBox> boxes);

  size_t node_count() const { return nodes_.size(); }
  uint64_t bytes() const { return nodes_.size() * sizeof(Node); }

  // Calls visit(primitive) for all whose boxes meet the ray in [s_min, s_max], near ones first; visit may lower s_max,
  // and ends the traversal by returning true. Only strictly farther boxes are culled.
  template <class Cost, class Visit>
  bool traverse(const FrameRay& ray, float s_min, const float& s_max, Cost& cost, Visit&& visit) const {
    struct Entry {
      float s;
      uint32_t child;
    };
    Entry stack[Bvh::kMaxDepth * (kLanes - 1) + kLanes];
    int top = 0;
    uint32_t current = 0;
    for (;;) {
      cost.step();
      const Node& node = nodes_[current];
      Float8 from;
      const Mask8 met = meets(node.boxes, ray, s_min, s_max, from) & (kLaneNumbers < node.count);
      push(stack, top, met, from, [&](float s, int lane) { return Entry{s, node.child[lane]}; });
      for (;;) {
        do {
          if (top == 0) return false;
          --top;
        } while (stack[top].s > s_max);
        current = stack[top].child;
        if (!(current & kPrimitive)) break;
        cost.test(1);
        if (visit(current & ~kPrimitive)) return true;
      }
    }
  }

  // The same for several lines that should be alike, each in its own range: visit(primitive, lanes) with those that meet
  // the primitive's box, by clip(lo, hi, lanes). `beam`: around all of them.
  template <class Beam, class Clip, class Visit>
  void traverse_together(const Beam& beam, uint32_t lanes, const float& s_max, Clip&& clip, Visit&& visit) const {
    struct Entry {
      float s;
      uint32_t node, lane;  // whose child
    };
    Entry stack[Bvh::kMaxDepth * (kLanes - 1) + kLanes];
    int top = 0;
    uint32_t current = 0;
    for (;;) {
      const Node& node = nodes_[current];
      Float8 from;
      const Mask8 met_boxes = beam.meets(node.boxes, s_max, from) & (kLaneNumbers < node.count);
      push(stack, top, met_boxes, from,
           [&](float s, int lane) { return Entry{s, current, static_cast<uint32_t>(lane)}; });
      for (;;) {
        if (top == 0) return;
        const Entry entry = stack[--top];
        if (entry.s > s_max) continue;
        const BoxLanes& boxes = nodes_[entry.node].boxes;
        const float lo[3] = {boxes.lo[0][entry.lane], boxes.lo[1][entry.lane], boxes.lo[2][entry.lane]};
        const float hi[3] = {boxes.hi[0][entry.lane], boxes.hi[1][entry.lane], boxes.hi[2][entry.lane]};
        const uint32_t met = clip(lo, hi) & lanes;
        if (met == 0) continue;
        current = nodes_[entry.node].child[entry.lane];
        if (!(current & kPrimitive)) break;
        visit(current & ~kPrimitive, met);
      }
    }
  }

 private:
  static constexpr uint32_t kPrimitive = 1u << 31;
  struct alignas(32) Node {  // 256 bytes
    BoxLanes boxes;
    uint32_t child[kLanes];  // a node's number, or kPrimitive | a primitive's
    int32_t count;
  };

  // Puts a node's children that were met on the stack, entry(s, lane) each, the nearest on top.
  template <class Entry, class Make>
  static void push(Entry* stack, int& top, const Mask8& met, const Float8& from, Make&& entry) {
    alignas(32) float near[kLanes];
    std::memcpy(near, &from, sizeof(near));
    const int waiting = top;
    for (uint32_t left = bits(met); left != 0; left &= left - 1) {
      const int lane = std::countr_zero(left);
      int at = top++;
      for (; at > waiting && stack[at - 1].s < near[lane]; --at) stack[at] = stack[at - 1];
      stack[at] = entry(near[lane], lane);
    }
  }

  std::vector<Node> nodes_;
};

}  // namespace tilecast
