// Improves a finished tree: nodes are taken out and put back where they cost least.
//
// Bittner, Hapala and Havran, "Fast Insertion-Based Optimization of Bounding Volume Hierarchies", CGF 32(1), 2013: the
// best place is found by branch and bound over the growth of the boxes that an insertion causes. Children stand side by
// side, so the pair that a removal frees is the pair that the insertion needs.
#include <numeric>

#include "accel/bvh.h"

namespace tilecast {
namespace {

constexpr int kPasses = 3;
constexpr double kShare = 0.02;  // of the nodes, the largest ones: the upper levels are where it pays

using Node = Bvh::Node;

class Optimiser {
 public:
  explicit Optimiser(std::vector<Node>& nodes) : nodes_(nodes), parent_(nodes.size(), 0) {
    for (uint32_t i = 0; i < nodes_.size(); ++i) adopt(i);
  }

  // Returns how many nodes found a better place.
  size_t pass() {
    std::vector<uint32_t> candidates(nodes_.size() - 1);
    std::iota(candidates.begin(), candidates.end(), 1u);
    size_t count = std::min(candidates.size(), std::max<size_t>(64, static_cast<size_t>(kShare * candidates.size())));
    auto larger = [&](uint32_t a, uint32_t b) {
      float x = nodes_[a].box().half_area(), y = nodes_[b].box().half_area();
      return x > y || (x == y && a < b);
    };
    std::partial_sort(candidates.begin(), candidates.begin() + count, candidates.end(), larger);
    size_t moved = 0;
    for (size_t i = 0; i < count; ++i) moved += reinsert(candidates[i]);
    return moved;
  }

 private:
  static uint32_t sibling(uint32_t i) { return i % 2 ? i + 1 : i - 1; }  // pairs begin at odd indices

  void adopt(uint32_t i) {
    if (nodes_[i].count > 0) return;
    parent_[nodes_[i].first] = parent_[nodes_[i].first + 1] = i;
  }

  void refit_from(uint32_t i) {
    for (;; i = parent_[i]) {
      const uint32_t children = nodes_[i].first;
      nodes_[i].set_box(nodes_[children].box().joined(nodes_[children + 1].box()));
      if (i == 0) return;
    }
  }

  // The node whose sibling `loose` had best become: the sum of all boxes' surfaces grows least.
  uint32_t best_place(const FrameBox& loose) {
    const float own = loose.half_area();
    float best_cost = std::numeric_limits<float>::infinity();
    uint32_t best = 0;
    open_.assign(1, {0.0f, 0});
    while (!open_.empty()) {
      Place place = open_.front();
      std::pop_heap(open_.begin(), open_.end());
      open_.pop_back();
      if (place.induced + own >= best_cost) break;  // no place is cheaper than its ancestors' growth and the node
      const Node& there = nodes_[place.node];
      const FrameBox box = there.box();
      float direct = box.joined(loose).half_area();
      if (place.induced + direct < best_cost) best_cost = place.induced + direct, best = place.node;
      float induced = place.induced + direct - box.half_area();
      if (there.count > 0 || induced + own >= best_cost) continue;
      for (uint32_t child : {there.first, there.first + 1}) {
        open_.push_back({induced, child});
        std::push_heap(open_.begin(), open_.end());
      }
    }
    return best;
  }

  bool reinsert(uint32_t node) {
    const uint32_t parent = parent_[node], brother = sibling(node), pair = std::min(node, brother);
    const Node loose = nodes_[node];
    // The sibling takes the parent's place, and the pair is free.
    nodes_[parent] = nodes_[brother];
    adopt(parent);
    if (parent != 0) refit_from(parent_[parent]);
    uint32_t target = best_place(loose.box());
    // The pair holds what was at the target, and the node.
    nodes_[pair] = nodes_[target];
    nodes_[pair + 1] = loose;
    adopt(pair);
    adopt(pair + 1);
    nodes_[target].first = pair;
    nodes_[target].count = 0;
    adopt(target);
    refit_from(target);
    return target != parent;
  }

  struct Place {
    float induced;  // growth of the ancestors
    uint32_t node;
    bool operator<(const Place& other) const { return induced > other.induced; }  // the least on top of the heap
  };
  std::vector<Place> open_;
  std::vector<Node>& nodes_;
  std::vector<uint32_t> parent_;
};

}  // namespace

void Bvh::optimise_by_reinsertion() {
  if (nodes_.size() < 5) return;
  Bvh before = *this;
  Optimiser optimiser(nodes_);
  for (int i = 0; i < kPasses; ++i)
    if (optimiser.pass() == 0) break;
  if (depth() > kMaxDepth - 1) *this = before;  // the traversal's stack is fixed
}

}  // namespace tilecast
