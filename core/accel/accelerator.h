// The one interface of all accelerators: boxes in, leaves out. It serves triangles in a mesh and objects in a group.
#pragma once

#include <string>
#include <string_view>
#include <variant>

#include "accel/brute_force.h"
#include "accel/bsp.h"
#include "accel/bvh.h"
#include "accel/grid.h"
#include "accel/octree.h"

namespace tilecast {

// Every kind by name, but for `auto`.
const std::vector<std::string>& accelerator_kinds();
const std::vector<std::string>& grouping_names();

struct AcceleratorChoice {
  std::string kind = "auto";
  std::string grouping = "sah";  // what a bvh groups: sah, sah-sweep, median, middle or morton
  bool reinsertion = false;      // optimises a bvh after it is built
  int threads = 1;               // that build a bvh by sah; the tree does not depend on them

  AcceleratorChoice() = default;
  AcceleratorChoice(std::string_view name) : kind(name) {}
  AcceleratorChoice(const char* name) : kind(name) {}
  void check() const;  // throws Error
};

struct AcceleratorStats {
  std::string kind;
  uint64_t nodes = 0;       // nodes, or cells
  uint64_t references = 0;  // to primitives: more than these where one stands in several boxes
  uint64_t bytes = 0;
  double seconds = 0.0;     // to build
  double cost = 0.0;        // expected of a line through the whole: steps, and tests at their cost in steps
};

class Accelerator {
 public:
  // `auto` goes without for a handful of primitives, and otherwise takes the hierarchy with the least expected cost.
  static Accelerator build(const AcceleratorChoice& choice, const PrimitiveSet& primitives);

  // Primitives in the order of the leaves.
  const std::vector<uint32_t>& order() const { return order_; }
  const AcceleratorStats& stats() const { return stats_; }
  bool is_hierarchy() const { return std::holds_alternative<Bvh>(structure_); }  // a bvh or sbvh
  const Bvh& hierarchy() const { return std::get<Bvh>(structure_); }
  // Drops the structure for another that was made of it in so many seconds more; the statistics tell of that one.
  void give_way(uint64_t nodes, uint64_t bytes, double seconds);
  // Whether a traversal offers a primitive once. Otherwise a mailbox keeps most repetitions away, not all.
  bool visits_once() const { return visits_once_; }

  // Calls leaf(first, count) for stretches of order(): all primitives whose padded boxes the ray meets in
  // [s_min, s_max], near ones first as far as the structure knows. The leaf may lower s_max (only what is strictly
  // farther is left out), and ends the traversal by returning true.
  template <class Cost, class Leaf>
  bool traverse(const FrameRay& ray, float s_min, const float& s_max, Cost& cost, Leaf&& leaf) const {
    auto counted = [&](uint32_t first, uint32_t count) {
      cost.test(count);
      return leaf(first, count);
    };
    if (auto* bvh = std::get_if<Bvh>(&structure_); bvh && visits_once_)
      return bvh->traverse(ray, s_min, s_max, cost, counted);
    if (auto* all = std::get_if<BruteForce>(&structure_)) return all->traverse(ray, s_min, s_max, cost, counted);
    Mailbox mailbox;
    auto unseen = [&](uint32_t first, uint32_t count) {
      for (uint32_t i = first; i < first + count; ++i)
        if (!mailbox.seen(order_[i]) && counted(i, 1)) return true;
      return false;
    };
    return std::visit([&](const auto& s) { return s.traverse(ray, s_min, s_max, cost, unseen); }, structure_);
  }

 private:
  std::variant<BruteForce, Bvh, Grid, Octree, Bsp> structure_;
  bool visits_once_ = true;
  std::vector<uint32_t> order_;
  AcceleratorStats stats_;
};

}  // namespace tilecast
