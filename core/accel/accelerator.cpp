#include "accel/accelerator.h"

#include <chrono>

#include "accel/wide_bvh.h"
#include "base/error.h"
#include "base/lanes.h"

namespace tilecast {
namespace {

constexpr double kSpatialSplitReferences = 3;  // at most, for each primitive
// A spatial split has to promise this much before `auto` takes it: repeated references cost cache.
constexpr double kSpatialSplitGain = 0.9;
constexpr double kOverlap = 0.25;  // of a hierarchy's cost: with less, `auto` does not try them

std::string list(const std::vector<std::string>& names) {
  std::string out;
  for (const std::string& name : names) out += (out.empty() ? "" : ", ") + name;
  return out;
}

bool among(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

Grouping grouping_of(const std::string& name) {
  const auto& names = grouping_names();
  return static_cast<Grouping>(std::find(names.begin(), names.end(), name) - names.begin());
}

}  // namespace

const std::vector<std::string>& accelerator_kinds() {
  static const std::vector<std::string> names{"none",   "bvh",             "sbvh", "grid",      "grid-two-level",
                                              "octree", "octree-balanced", "bsp",  "bsp-median"};
  return names;
}

const std::vector<std::string>& grouping_names() {  // in the order of Grouping
  static const std::vector<std::string> names{"sah", "sah-sweep", "median", "middle", "morton"};
  return names;
}

void AcceleratorChoice::check() const {
  if (kind != "auto" && !among(accelerator_kinds(), kind))
    throw Error("accelerator: must be one of auto, " + list(accelerator_kinds()) + ", got " + kind);
  if (!among(grouping_names(), grouping))
    throw Error("grouping: must be one of " + list(grouping_names()) + ", got " + grouping);
}

Accelerator Accelerator::build(const AcceleratorChoice& choice, const PrimitiveSet& primitives) {
  auto start = std::chrono::steady_clock::now();
  choice.check();
  const size_t count = primitives.size();
  const uint32_t together = primitives.tested_together();
  if (count > (1u << 30)) throw Error("more than 2^30 primitives in one object");
  std::string kind = choice.kind;
  // Up to eight boxes are met at once, whatever stands above them. A mesh's triangles are, too, but in its hierarchy.
  if (count == 0 || (kind == "auto" && count <= kLanes && !primitives.mesh)) kind = "none";

  Accelerator out;
  auto spatial_splits = [&](std::vector<uint32_t>& order) {
    const size_t most = static_cast<size_t>(kSpatialSplitReferences * count);
    return Bvh::build_with_spatial_splits(primitives, most, order, choice.threads);
  };
  if (kind == "none") {
    out.structure_ = BruteForce::build(primitives, out.order_);
  } else if (kind == "auto" || kind == "bvh") {
    Bvh bvh = Bvh::build(primitives, grouping_of(choice.grouping), out.order_, choice.threads);
    if (choice.reinsertion) bvh.optimise_by_reinsertion();
    if (kind == "auto") {
      kind = "bvh";
      // What is traced: of a mesh, the hierarchy that is folded.
      auto cost_of = [&](const Bvh& some) {
        return primitives.mesh ? WideBvh::folded_cost(some, choice.threads) : some.expected_cost(primitives.test_cost);
      };
      if (bvh.overlap_cost(primitives.test_cost, together) >
          kOverlap * bvh.expected_cost(primitives.test_cost, together)) {
        std::vector<uint32_t> order;
        Bvh split = spatial_splits(order);
        if (cost_of(split) < kSpatialSplitGain * cost_of(bvh)) {
          kind = "sbvh";
          out.order_ = std::move(order);
          bvh = std::move(split);
        }
      }
    }
    out.structure_ = std::move(bvh);
  } else if (kind == "sbvh") {
    out.structure_ = spatial_splits(out.order_);
  } else if (kind == "grid" || kind == "grid-two-level") {
    out.structure_ = Grid::build(primitives, kind == "grid-two-level", out.order_);
  } else if (kind == "octree" || kind == "octree-balanced") {
    auto planes = kind == "octree" ? Octree::Planes::Even : Octree::Planes::Balanced;
    out.structure_ = Octree::build(primitives, planes, out.order_);
  } else {
    out.structure_ = Bsp::build(primitives, kind == "bsp" ? Bsp::Plane::Sah : Bsp::Plane::Median, out.order_);
  }
  const bool of_boxes =
      std::holds_alternative<BruteForce>(out.structure_) || std::holds_alternative<Bvh>(out.structure_);
  out.visits_once_ = of_boxes && out.order_.size() == count;
  AcceleratorStats& stats = out.stats_;
  stats.kind = kind;
  stats.references = out.order_.size();
  std::visit(
      [&](const auto& structure) {
        stats.nodes = structure.node_count();
        stats.bytes = structure.bytes() + out.order_.size() * sizeof(uint32_t);
        stats.cost = structure.expected_cost(primitives.test_cost);
      },
      out.structure_);
  stats.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return out;
}

void Accelerator::give_way(uint64_t nodes, uint64_t bytes, double seconds) {
  structure_ = BruteForce();
  order_ = {};
  stats_.nodes = nodes;
  stats_.bytes = bytes;
  stats_.seconds += seconds;
}

}  // namespace tilecast
