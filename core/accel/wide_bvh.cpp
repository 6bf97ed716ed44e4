// Folds a binary hierarchy into one with eight children, at the least expected cost: dynamic programming over what a
// subtree costs as a forest of at most i trees (Ylitie, Karras and Laine, "Efficient Incoherent Ray Traversal on GPUs
// Through Compressed Wide BVHs", HPG 2017, section 3.2).
#include "accel/wide_bvh.h"

namespace tilecast {
namespace {

constexpr int kWidth = WideNode::kWidth;
constexpr float kNodeCost = 1.0f, kBlockCost = 1.0f;  // of entering a node; of testing a block of triangles

class Folding {
 public:
  Folding(const Bvh& bvh) : bvh_(bvh), plans_(bvh.nodes().size()) {
    std::vector<uint32_t> before_children{0};
    before_children.reserve(plans_.size());
    for (size_t i = 0; i < before_children.size(); ++i)
      if (const Bvh::Node& node = bvh.nodes()[before_children[i]]; node.count == 0)
        before_children.insert(before_children.end(), {node.first, node.first + 1});
    for (size_t i = before_children.size(); i-- > 0;) plan(before_children[i]);
  }

  bool is_leaf(uint32_t node) const { return plans_[node].leaf; }

  // The roots of the forest that stands for a node's children.
  void children(uint32_t node, std::vector<uint32_t>& out) const { part(node, kWidth, plans_[node].at_root, out); }
  // The references under a node.
  void references(uint32_t node, const std::vector<uint32_t>& order, std::vector<uint32_t>& out) const {
    const Bvh::Node& n = bvh_.nodes()[node];
    if (n.count > 0) {
      out.insert(out.end(), order.begin() + n.first, order.begin() + n.first + n.count);
    } else {
      references(n.first, order, out);
      references(n.first + 1, order, out);
    }
  }

 private:
  struct Plan {
    float cost[kWidth - 1];      // [i]: as a forest of at most i + 1 trees
    uint8_t left[kWidth - 1];    // [i]: how many of them go to the left child; 0: as with one less
    uint8_t at_root;             // the same for the eight children of a node here
    bool leaf;
    uint32_t count;              // of references below
  };

  void plan(uint32_t i) {
    const Bvh::Node& node = bvh_.nodes()[i];
    Plan& plan = plans_[i];
    const float area = box(node).half_area();
    if (node.count > 0) {
      plan.count = node.count;
      plan.leaf = true;
      std::fill_n(plan.cost, kWidth - 1, kBlockCost * area);
      std::fill_n(plan.left, kWidth - 1, uint8_t(0));
      return;
    }
    const Plan &l = plans_[node.first], &r = plans_[node.first + 1];
    plan.count = l.count + r.count;
    auto cheapest = [&](int trees, uint8_t& left) {
      float best = FrameBox::kFar;
      for (int k = 1; k < trees; ++k) {
        float cost = l.cost[k - 1] + r.cost[trees - k - 1];
        if (cost < best) best = cost, left = static_cast<uint8_t>(k);
      }
      return best;
    };
    float inner = cheapest(kWidth, plan.at_root) + kNodeCost * area;
    float leaf = plan.count <= kWidth ? kBlockCost * area : FrameBox::kFar;
    plan.leaf = leaf <= inner;
    plan.cost[0] = std::min(leaf, inner);
    plan.left[0] = 0;
    for (int trees = 2; trees < kWidth; ++trees) {
      plan.cost[trees - 1] = cheapest(trees, plan.left[trees - 1]);
      if (plan.cost[trees - 2] <= plan.cost[trees - 1]) plan.cost[trees - 1] = plan.cost[trees - 2], plan.left[trees - 1] = 0;
    }
  }

  static FrameBox box(const Bvh::Node& n) { return {{n.lo[0], n.lo[1], n.lo[2]}, {n.hi[0], n.hi[1], n.hi[2]}}; }

  void part(uint32_t node, int trees, int left, std::vector<uint32_t>& out) const {
    uint32_t child = bvh_.nodes()[node].first;
    forest(child, left, out);
    forest(child + 1, trees - left, out);
  }
  void forest(uint32_t node, int trees, std::vector<uint32_t>& out) const {
    while (trees > 1 && plans_[node].left[trees - 1] == 0) --trees;
    if (trees == 1) {
      out.push_back(node);
    } else {
      part(node, trees, plans_[node].left[trees - 1], out);
    }
  }

  const Bvh& bvh_;
  std::vector<Plan> plans_;
};

TriangleBlock block_of(std::span<const uint32_t> faces, const Mesh& mesh) {
  TriangleBlock block;
  for (int lane = 0; lane < kWidth; ++lane) {
    bool used = lane < static_cast<int>(faces.size());
    block.face[lane] = used ? faces[lane] : TriangleBlock::kNone;
    Triangle t = used ? mesh.triangle(faces[lane]) : Triangle{};
    for (int axis = 0; axis < 3; ++axis) {
      constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();
      block.vertices[0][axis][lane] = used ? t.a[axis] : kNothing;
      block.vertices[1][axis][lane] = used ? t.b[axis] : kNothing;
      block.vertices[2][axis][lane] = used ? t.c[axis] : kNothing;
    }
  }
  return block;
}

// Moves the children to their slots: the one that lies farthest along a slot's diagonal takes it, of all that are left.
void arrange(WideNode& node, int used) {
  float offset[kWidth][3];  // of the children's centres from their mean
  float mean[3] = {};
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < used; ++i) {
      offset[i][axis] = 0.5f * (node.planes[2 * axis][i] + node.planes[2 * axis + 1][i]);
      mean[axis] += offset[i][axis] / static_cast<float>(used);
    }
    for (int i = 0; i < used; ++i) offset[i][axis] -= mean[axis];
  }
  int from[kWidth];  // the child of each slot, or -1
  std::fill_n(from, kWidth, -1);
  for (uint32_t placed = 0, round = 0; round < static_cast<uint32_t>(used); ++round) {
    float best = -FrameBox::kFar;
    int best_child = 0, best_slot = 0;
    for (int i = 0; i < used; ++i) {
      if (placed >> i & 1) continue;
      for (int slot = 0; slot < kWidth; ++slot) {
        if (from[slot] >= 0) continue;
        float along = 0.0f;
        for (int axis = 0; axis < 3; ++axis) along += slot >> axis & 1 ? offset[i][axis] : -offset[i][axis];
        if (along > best) best = along, best_child = i, best_slot = slot;
      }
    }
    from[best_slot] = best_child;
    placed |= 1u << best_child;
  }
  const WideNode before = node;
  for (int slot = 0; slot < kWidth; ++slot) {
    const int i = from[slot];
    for (int plane = 0; plane < 6; ++plane)
      node.planes[plane][slot] = i >= 0 ? before.planes[plane][i] : plane & 1 ? -FrameBox::kFar : FrameBox::kFar;
    node.child[slot] = i >= 0 ? before.child[i] : 0;
  }
}

}  // namespace

WideBvh WideBvh::fold(const Bvh& bvh, const std::vector<uint32_t>& order, const Mesh& mesh) {
  WideBvh out;
  Folding folding(bvh);
  std::vector<uint32_t> faces;
  auto leaf = [&](uint32_t node) {
    faces.clear();
    folding.references(node, order, faces);
    out.blocks_.push_back(block_of(faces, mesh));
    return WideNode::kLeaf | static_cast<uint32_t>(out.blocks_.size() - 1);
  };
  if (folding.is_leaf(0)) {
    out.root_ = leaf(0);
    return out;
  }
  struct Task {
    uint32_t node, at;
  };
  out.nodes_.emplace_back();
  std::vector<Task> tasks{{0, 0}};
  std::vector<uint32_t> children;
  while (!tasks.empty()) {
    Task task = tasks.back();
    tasks.pop_back();
    children.clear();
    folding.children(task.node, children);
    WideNode node;
    for (int i = 0; i < kWidth; ++i) {
      const bool used = i < static_cast<int>(children.size());
      for (int axis = 0; axis < 3; ++axis) {
        node.planes[2 * axis][i] = used ? bvh.nodes()[children[i]].lo[axis] : FrameBox::kFar;
        node.planes[2 * axis + 1][i] = used ? bvh.nodes()[children[i]].hi[axis] : -FrameBox::kFar;
      }
      node.child[i] = 0;
      if (!used) continue;
      if (folding.is_leaf(children[i])) {
        node.child[i] = leaf(children[i]);
      } else {
        node.child[i] = static_cast<uint32_t>(out.nodes_.size());
        out.nodes_.emplace_back();
        tasks.push_back({children[i], node.child[i]});
      }
    }
    arrange(node, static_cast<int>(children.size()));
    out.nodes_[task.at] = node;
  }
  return out;
}

}  // namespace tilecast
