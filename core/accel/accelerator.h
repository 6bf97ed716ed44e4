// The one interface of all accelerators: boxes in, leaves out. It serves triangles in a mesh and objects in a group.
#pragma once

#include <string>
#include <string_view>
#include <variant>

#include "accel/bvh.h"

namespace tilecast {

// No acceleration: every primitive, in order. The oracle that the others are tested against.
struct BruteForce {
  uint32_t count = 0;

  template <class Leaf>
  bool traverse(const FrameRay&, float, const float&, Leaf&& leaf) const {
    return count > 0 && leaf(0u, count);
  }
};

struct AcceleratorStats {
  std::string kind;
  uint64_t nodes = 0, bytes = 0;
  double seconds = 0.0;
};

class Accelerator {
 public:
  // kind: auto, none or bvh. `auto` goes without for a handful of primitives. test_cost: of a primitive, in steps from
  // a node to its child.
  static Accelerator build(std::string_view kind, std::span<const FrameBox> boxes, float test_cost);

  // Primitives in the order of the leaves.
  const std::vector<uint32_t>& order() const { return order_; }
  const AcceleratorStats& stats() const { return stats_; }

  // See Bvh::traverse.
  template <class Leaf>
  bool traverse(const FrameRay& ray, float s_min, const float& s_max, Leaf&& leaf) const {
    if (auto* bvh = std::get_if<Bvh>(&structure_)) return bvh->traverse(ray, s_min, s_max, leaf);
    return std::get<BruteForce>(structure_).traverse(ray, s_min, s_max, leaf);
  }

 private:
  std::variant<BruteForce, Bvh> structure_;
  std::vector<uint32_t> order_;
  AcceleratorStats stats_;
};

}  // namespace tilecast
