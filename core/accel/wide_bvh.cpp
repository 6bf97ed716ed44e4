// Folds a binary hierarchy into one with eight children, at the least expected cost: dynamic programming over what a
// subtree costs as a forest of at most i trees (Ylitie, Karras and Laine, "Efficient Incoherent Ray Traversal on GPUs
// Through Compressed Wide BVHs", HPG 2017, section 3.2).
#include "accel/wide_bvh.h"

#include "base/parallel.h"

namespace tilecast {
namespace {

constexpr int kWidth = WideNode::kWidth;
constexpr float kNodeCost = 1.0f, kBlockCost = 1.0f;  // of entering a node; of testing a block of triangles

class Folding {
 public:
  Folding(const Bvh& bvh, int threads) : nodes_(bvh.nodes()), plans_(nodes_.size()) {
    std::vector<uint32_t> subtrees;
    collect(0, 0, subtrees);
    std::vector<Costs> costs(subtrees.size());
    in_parallel(threads, subtrees.size(), [&](size_t i) { costs[i] = plan(subtrees[i]); });
    const Costs* next = costs.data();
    cost_ = plan_above(0, 0, next)[0];
  }

  float cost() const { return cost_; }  // times the root's half surface

  bool is_leaf(uint32_t node) const { return plans_[node].leaf; }
  FrameBox box(uint32_t node) const { return nodes_[node].box(); }

  // The roots of the forest that stands for a node's children: how many.
  int children(uint32_t node, uint32_t out[kWidth]) const {
    uint32_t* end = out;
    part(node, kWidth, end);
    return static_cast<int>(end - out);
  }
  // The references under a node: how many.
  int references(uint32_t node, const std::vector<uint32_t>& order, uint32_t out[kWidth]) const {
    const Bvh::Node& n = nodes_[node];
    if (n.count > 0) {
      std::copy_n(order.begin() + n.first, n.count, out);
      return static_cast<int>(n.count);
    }
    const int left = references(n.first, order, out);
    return left + references(n.first + 1, order, out + left);
  }

 private:
  using Costs = std::array<float, kWidth - 1>;  // [i]: as a forest of at most i + 1 trees
  struct Plan {
    uint8_t left[kWidth];  // [i]: of at most i + 1 trees, how many go to the left child; 0: as with one less
    uint8_t count;         // of references below; more than kWidth: kWidth + 1
    bool leaf;
  };

  // Subtrees are planned apart from each other, and what is above them at last.
  static constexpr int kDepthAbove = 8;
  bool above(uint32_t node, int depth) const { return depth < kDepthAbove && nodes_[node].count == 0; }
  void collect(uint32_t node, int depth, std::vector<uint32_t>& out) const {
    if (!above(node, depth)) return out.push_back(node);
    collect(nodes_[node].first, depth + 1, out);
    collect(nodes_[node].first + 1, depth + 1, out);
  }
  Costs plan_above(uint32_t node, int depth, const Costs*& next) {
    if (!above(node, depth)) return *next++;
    const Costs left = plan_above(nodes_[node].first, depth + 1, next);
    return plan_inner(node, left, plan_above(nodes_[node].first + 1, depth + 1, next));
  }
  Costs plan(uint32_t node) {
    const Bvh::Node& n = nodes_[node];
    if (n.count == 0) {
      const Costs left = plan(n.first);
      return plan_inner(node, left, plan(n.first + 1));
    }
    plans_[node] = {{}, static_cast<uint8_t>(n.count), true};
    Costs costs;
    costs.fill(kBlockCost * box(node).half_area());
    return costs;
  }

  Costs plan_inner(uint32_t node, const Costs& l, const Costs& r) {
    Plan plan{};
    plan.count = static_cast<uint8_t>(
        std::min(plans_[nodes_[node].first].count + plans_[nodes_[node].first + 1].count, kWidth + 1));
    auto cheapest = [&](int trees) {
      float best = FrameBox::kFar;
      int left = 1;
      for (int k = 1; k < trees; ++k) {
        const float cost = l[k - 1] + r[trees - k - 1];
        left = cost < best ? k : left;
        best = cost < best ? cost : best;
      }
      plan.left[trees - 1] = static_cast<uint8_t>(left);
      return best;
    };
    const float area = box(node).half_area();
    const float inner = cheapest(kWidth) + kNodeCost * area;
    const float leaf = plan.count <= kWidth ? kBlockCost * area : FrameBox::kFar;
    plan.leaf = leaf <= inner;
    Costs costs;
    costs[0] = std::min(leaf, inner);
    for (int trees = 2; trees < kWidth; ++trees) {
      costs[trees - 1] = cheapest(trees);
      if (costs[trees - 2] <= costs[trees - 1]) costs[trees - 1] = costs[trees - 2], plan.left[trees - 1] = 0;
    }
    plans_[node] = plan;
    return costs;
  }

  void part(uint32_t node, int trees, uint32_t*& out) const {
    const uint32_t child = nodes_[node].first;
    const int left = plans_[node].left[trees - 1];
    forest(child, left, out);
    forest(child + 1, trees - left, out);
  }
  void forest(uint32_t node, int trees, uint32_t*& out) const {
    while (trees > 1 && plans_[node].left[trees - 1] == 0) --trees;
    if (trees == 1) {
      *out++ = node;
    } else {
      part(node, trees, out);
    }
  }

  const std::vector<Bvh::Node>& nodes_;
  LargeArray<Plan> plans_;
  float cost_;
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

// Moves the children to their slots: of all that are left, the one that lies farthest along a slot's diagonal takes it.
void arrange(WideNode& node, int used) {
  float offset[3][kWidth];  // of the children's centres from their mean
  for (int axis = 0; axis < 3; ++axis) {
    float mean = 0.0f;
    for (int i = 0; i < used; ++i) {
      offset[axis][i] = 0.5f * (node.planes[2 * axis][i] + node.planes[2 * axis + 1][i]);
      mean += offset[axis][i] / static_cast<float>(used);
    }
    for (int i = 0; i < used; ++i) offset[axis][i] -= mean;
  }
  float along[kWidth][kWidth];  // [child][slot]
  for (int i = 0; i < used; ++i)
    for (int slot = 0; slot < kWidth; ++slot)
      along[i][slot] = (slot & 1 ? offset[0][i] : -offset[0][i]) + (slot & 2 ? offset[1][i] : -offset[1][i]) +
                       (slot & 4 ? offset[2][i] : -offset[2][i]);
  int from[kWidth];  // the child of each slot, or -1
  std::fill_n(from, kWidth, -1);
  for (uint32_t placed = 0, round = 0; round < static_cast<uint32_t>(used); ++round) {
    float best = -FrameBox::kFar;
    int best_child = 0, best_slot = 0;
    for (int i = 0; i < used; ++i) {
      if (placed >> i & 1) continue;
      for (int slot = 0; slot < kWidth; ++slot)
        if (from[slot] < 0 && along[i][slot] > best) best = along[i][slot], best_child = i, best_slot = slot;
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

// Writes the wide nodes under one, and its blocks, from given numbers on.
class Writer {
 public:
  struct Task {
    uint32_t node, at;  // of the binary hierarchy; of the wide one
    int depth;
  };
  struct Size {
    uint32_t nodes = 0, blocks = 0;
  };

  Writer(const Folding& folding, const std::vector<uint32_t>& order, const Mesh& mesh)
      : folding_(folding), order_(order), mesh_(mesh) {}

  // What is under a node: it is not counted itself.
  Size size_below(uint32_t node) const {
    uint32_t children[kWidth];
    Size size;
    const int count = folding_.children(node, children);
    for (int i = 0; i < count; ++i) {
      if (folding_.is_leaf(children[i])) {
        ++size.blocks;
      } else {
        const Size below = size_below(children[i]);
        size.nodes += below.nodes + 1, size.blocks += below.blocks;
      }
    }
    return size;
  }

  // `next`: the first numbers that are free. Nodes at `depth` are left to do.
  void write(const Task& root, int depth, Size& next, WideNode* nodes, TriangleBlock* blocks,
             std::vector<Task>& left) const {
    std::vector<Task> tasks{root};
    while (!tasks.empty()) {
      const Task task = tasks.back();
      tasks.pop_back();
      if (task.depth == depth) {
        left.push_back(task);
        continue;
      }
      uint32_t children[kWidth];
      const int used = folding_.children(task.node, children);
      WideNode& node = nodes[task.at];
      for (int i = 0; i < kWidth; ++i) {
        const FrameBox box = i < used ? folding_.box(children[i]) : FrameBox{};
        for (int axis = 0; axis < 3; ++axis)
          node.planes[2 * axis][i] = box.lo[axis], node.planes[2 * axis + 1][i] = box.hi[axis];
        node.child[i] = 0;
        if (i >= used) continue;
        if (folding_.is_leaf(children[i])) {
          node.child[i] = WideNode::kLeaf | next.blocks;
          blocks[next.blocks++] = block(children[i]);
        } else {
          node.child[i] = next.nodes;
          tasks.push_back({children[i], next.nodes++, task.depth + 1});
        }
      }
      arrange(node, used);
    }
  }

  TriangleBlock block(uint32_t node) const {
    uint32_t faces[kWidth];
    const int count = folding_.references(node, order_, faces);
    return block_of({faces, static_cast<size_t>(count)}, mesh_);
  }

 private:
  const Folding& folding_;
  const std::vector<uint32_t>& order_;
  const Mesh& mesh_;
};

}  // namespace

double WideBvh::folded_cost(const Bvh& bvh, int threads) {
  return Folding(bvh, threads).cost() / static_cast<double>(bvh.nodes()[0].box().half_area());
}

WideBvh WideBvh::fold(const Bvh& bvh, const std::vector<uint32_t>& order, const Mesh& mesh, int threads) {
  WideBvh out;
  const Folding folding(bvh, threads);
  const Writer writer(folding, order, mesh);
  if (folding.is_leaf(0)) {
    out.root_ = WideNode::kLeaf;
    out.blocks_.push_back(writer.block(0));
    return out;
  }
  // Two levels first; then what hangs on them, each subtree in its own stretch.
  constexpr int kLevels = 2;
  Writer::Size size{1, 0};
  std::vector<Writer::Task> subtrees;
  out.nodes_.resize(1 + kWidth + kWidth * kWidth);
  out.blocks_.resize(kWidth + kWidth * kWidth);
  writer.write({0, 0, 0}, kLevels, size, out.nodes_.data(), out.blocks_.data(), subtrees);
  std::vector<Writer::Size> sizes(subtrees.size());
  in_parallel(threads, subtrees.size(), [&](size_t i) { sizes[i] = writer.size_below(subtrees[i].node); });
  for (Writer::Size& first : sizes) {
    const Writer::Size below = first;
    first = size;
    size.nodes += below.nodes, size.blocks += below.blocks;
  }
  auto set_size = [](auto& v, size_t n) { v.reserve(n), v.resize(n), v.shrink_to_fit(); };  // in one piece
  set_size(out.nodes_, size.nodes);
  set_size(out.blocks_, size.blocks);
  in_parallel(threads, subtrees.size(), [&](size_t i) {
    std::vector<Writer::Task> none;
    writer.write(subtrees[i], -1, sizes[i], out.nodes_.data(), out.blocks_.data(), none);
  });
  return out;
}

}  // namespace tilecast
