// A bounding volume hierarchy for triangles, eight children a node and up to eight triangles a leaf, laid out for
// vectors of eight floats (compare Wald, Benthin and Boulos, "Getting Rid of Packets", RT 2008; Afra, "Incoherent Ray
// Tracing without Acceleration Structures" is the other end). It is folded out of a binary hierarchy.
#pragma once

#include <algorithm>
#include <vector>

#include "accel/bvh.h"
#include "base/large_array.h"

namespace tilecast {

// Children stand in slots by where they lie from each other: where bit i of a slot is set, towards the high side of axis
// i. A ray whose direction's octant is o meets the slots about in the order of slot ^ o (Ylitie, Karras and Laine,
// HPG 2017, section 3.3).
struct alignas(32) WideNode {  // 224 bytes
  static constexpr int kWidth = 8;
  static constexpr uint32_t kLeaf = 1u << 31;

  float planes[6][kWidth];   // x lo, x hi, y lo, y hi, z lo, z hi; where there is no child: lo inf, hi -inf
  uint32_t child[kWidth];    // a node's number, or kLeaf | a block's number
};

struct alignas(32) TriangleBlock {  // 320 bytes
  float vertices[3][3][WideNode::kWidth];  // [vertex][axis][lane], frame coordinates; unused lanes: NaN
  uint32_t face[WideNode::kWidth];         // unused lanes: kNone

  static constexpr uint32_t kNone = ~0u;
};

class WideBvh {
 public:
  static constexpr int kMaxDepth = Bvh::kMaxDepth;
  static constexpr int kStackSize = kMaxDepth * (WideNode::kWidth - 1) + 2 * WideNode::kWidth;

  // `order`: the faces in the order of the hierarchy's leaves. The same for any number of threads.
  static WideBvh fold(const Bvh& bvh, const std::vector<uint32_t>& order, const Mesh& mesh, int threads = 1);

  // Nodes and blocks that a line through the root is expected to meet once the hierarchy is folded.
  static double folded_cost(const Bvh& bvh, int threads = 1);

  const LargeArray<WideNode>& nodes() const { return nodes_; }
  const LargeArray<TriangleBlock>& blocks() const { return blocks_; }
  uint32_t root() const { return root_; }  // as a child
  uint64_t bytes() const { return nodes_.size() * sizeof(WideNode) + blocks_.size() * sizeof(TriangleBlock); }

 private:
  LargeArray<WideNode> nodes_;
  LargeArray<TriangleBlock> blocks_;
  uint32_t root_ = 0;
};

}  // namespace tilecast
