#include "accel/accelerator.h"

#include <chrono>
#include <numeric>

#include "base/error.h"

namespace tilecast {
namespace {

constexpr size_t kFew = 32;                    // primitives for which `auto` may go without
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
  if (count > (1u << 30)) throw Error("more than 2^30 primitives in one object");
  std::string kind = choice.kind;
  if (count == 0) kind = "none";

  Accelerator out;
  AcceleratorStats& stats = out.stats_;
  auto take = [&](auto structure, uint64_t nodes, uint64_t bytes) {
    stats.nodes = nodes;
    stats.bytes = bytes;
    stats.cost = structure.expected_cost(primitives.test_cost);
    out.structure_ = std::move(structure);
  };
  auto take_bvh = [&](Bvh bvh) {
    const uint64_t nodes = bvh.nodes().size();
    take(std::move(bvh), nodes, nodes * sizeof(Bvh::Node));
  };
  auto spatial_splits = [&](std::vector<uint32_t>& order) {
    return Bvh::build_with_spatial_splits(primitives, static_cast<size_t>(kSpatialSplitReferences * count), order);
  };
  auto take_all = [&] {
    out.order_.resize(count);
    std::iota(out.order_.begin(), out.order_.end(), 0u);
    BruteForce all{static_cast<uint32_t>(count), {}};
    if (primitives.test_cost > 1.0f) all.boxes.assign(primitives.boxes.begin(), primitives.boxes.end());
    const uint64_t bytes = all.boxes.size() * sizeof(FrameBox);
    take(std::move(all), 0, bytes);
    out.visits_once_ = true;
  };
  out.visits_once_ = false;
  if (kind == "none") {
    take_all();
  } else if (kind == "auto" || kind == "bvh") {
    Bvh bvh = Bvh::build(primitives, grouping_of(choice.grouping), out.order_);
    if (choice.reinsertion) bvh.optimise_by_reinsertion();
    const double overlap = bvh.overlap_cost(primitives.test_cost);
    take_bvh(std::move(bvh));
    out.visits_once_ = true;
    if (kind == "auto") {
      kind = "bvh";
      const double cost = stats.cost;
      if (count <= kFew) {
        Accelerator all = build("none", primitives);
        if (all.stats_.cost < cost) return all;
      }
      if (overlap > kOverlap * cost) {
        std::vector<uint32_t> order;
        Bvh split = spatial_splits(order);
        if (split.expected_cost(primitives.test_cost) < kSpatialSplitGain * cost) {
          kind = "sbvh";
          out.order_ = std::move(order);
          out.visits_once_ = out.order_.size() == count;
          take_bvh(std::move(split));
        }
      }
    }
  } else if (kind == "sbvh") {
    take_bvh(spatial_splits(out.order_));
    out.visits_once_ = out.order_.size() == count;
  } else if (kind == "grid" || kind == "grid-two-level") {
    Grid grid = Grid::build(primitives, kind == "grid-two-level", out.order_);
    const uint64_t cells = grid.cell_count(), bytes = grid.bytes();
    take(std::move(grid), cells, bytes);
  } else if (kind == "octree" || kind == "octree-balanced") {
    auto planes = kind == "octree" ? Octree::Planes::Even : Octree::Planes::Balanced;
    Octree octree = Octree::build(primitives, planes, out.order_);
    const uint64_t nodes = octree.node_count(), bytes = octree.bytes();
    take(std::move(octree), nodes, bytes);
  } else {
    Bsp bsp = Bsp::build(primitives, kind == "bsp" ? Bsp::Plane::Sah : Bsp::Plane::Median, out.order_);
    const uint64_t nodes = bsp.node_count(), bytes = bsp.bytes();
    take(std::move(bsp), nodes, bytes);
  }
  stats.kind = kind;
  stats.references = out.order_.size();
  stats.bytes += out.order_.size() * sizeof(uint32_t);
  stats.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return out;
}

}  // namespace tilecast
