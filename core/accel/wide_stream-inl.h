// Unlike rays through a WideBvh, many in turns: each moves by one node or block, and then waits with those that are at the
// same kind of thing. What a ray does next is a number that is added and not a branch, so that the processor does not guess
// wrong, and is at other rays while memory answers. (Compare Tsakok, "Faster Incoherent Rays: Multi-BVH Ray Stream
// Tracing", HPG 2009, and, for lookups in databases, Kocberber, Falsafi and Grot, "Asynchronous Memory Access Chaining",
// VLDB 2015.)
#if defined(TILECAST_WIDE_STREAM_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TILECAST_WIDE_STREAM_INL_H
#undef TILECAST_WIDE_STREAM_INL_H
#else
#define TILECAST_WIDE_STREAM_INL_H
#endif

#include "accel/wide_refine-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tilecast::HWY_NAMESPACE {

class Stream {
 public:
  static constexpr int kSize = FrameRays::kSize;

  // What a ray has before it: nothing, and then what is pushed, the nearest last, at most kMostPushed.
  static constexpr int kMostPushed = 40;
  HWY_INLINE void begin(int ray) {
    waiting_[ray].child[0] = kEnd;
    waiting_[ray].near[0] = -FrameBox::kFar;  // never beyond a hit
    top_[ray] = 1;
  }
  HWY_INLINE void push(int ray, uint32_t child, float near) {
    Waiting& waiting = waiting_[ray];
    const uint32_t top = top_[ray]++;
    waiting.child[top] = child, waiting.near[top] = near;
  }

  // Traces the lanes of `which`, that have begun; query_of(lane) is what is wanted of each. Answers which have too much
  // waiting: they may begin anew on their own. `from_memory`: the cache does not keep the hierarchy.
  template <class QueryOf>
  HWY_INLINE uint64_t trace(const WideBvh& bvh, bool from_memory, FrameRays& rays, uint64_t which, QueryOf&& query_of) {
    using Query = decltype(query_of(0));
    const WideNode* nodes = bvh.nodes().data();
    const TriangleBlock* blocks = bvh.blocks().data();
    uint64_t left = 0;
    Lists lists{nodes, blocks, from_memory, 0, 0};
    for (uint64_t rest = which; rest; rest &= rest - 1) {
      const uint32_t ray = static_cast<uint32_t>(std::countr_zero(rest));
      pop(lists, ray, top_[ray]);
    }
    while (lists.nodes + lists.blocks > 0) {
      const uint32_t in_nodes = lists.nodes;
      lists.nodes = 0;
      for (uint32_t i = 0; i < in_nodes; ++i) {
        const uint32_t ray = at_node_[i];
        fetch_ahead(lists, at_node_, i, in_nodes);
        const uint32_t top = enter_node<Query::kShortens>(nodes[child_[ray]], rays, ray);
        if (top > kMostWaiting) [[unlikely]] {
          left |= uint64_t(1) << ray;
          continue;
        }
        pop(lists, ray, top);
      }
      const uint32_t in_blocks = lists.blocks;
      lists.blocks = 0;
      uint32_t crossed_blocks = 0;
      for (uint32_t i = 0; i < in_blocks; ++i) {
        const uint32_t ray = at_block_[i];
        const TriangleBlock& block = blocks[child_[ray] & ~WideNode::kLeaf];
        fetch_ahead(lists, at_block_, i, in_blocks);
        const RayLanes lanes(rays, static_cast<int>(ray));
        const Crossed found = lanes.crossed(block);
        const uint32_t some = found.some != 0, none = some ^ 1;
        crossed_[crossed_blocks] = {&block, ray, found};
        crossed_blocks += some;
        // A ray with candidates stays out of the lists.
        const uint32_t next = waiting_[ray].child[top_[ray] - 1];
        top_[ray] -= none, child_[ray] = next;
        at_node_[lists.nodes] = static_cast<uint8_t>(ray), lists.nodes += none & is_node(next);
        at_block_[lists.blocks] = static_cast<uint8_t>(ray), lists.blocks += none & is_block(next);
        fetch(lists, next);
      }
      if (crossed_blocks > 0) decide<Query::kShortens>(lists, crossed_blocks, rays, query_of);
    }
    return left;
  }

 private:
  static constexpr uint32_t kMostWaiting = 48;  // children of a ray: little, so that all stacks are in the nearest cache
  static constexpr uint32_t kEnd = ~0u;  // nothing waits; no block has this number
  static uint32_t is_node(uint32_t child) { return ~child >> 31; }
  static uint32_t is_block(uint32_t child) { return (child + 1) >> 31; }

  struct Lists {
    const WideNode* node;
    const TriangleBlock* block;
    bool from_memory;
    uint32_t nodes, blocks;  // how many rays are at one
  };

  // Asks for what a ray will look at in its next turn.
  static HWY_INLINE void fetch(const Lists& lists, uint32_t child) {
    if (!lists.from_memory) return;
    if (child == kEnd) child = 0;  // no matter which
    HWY_NAMESPACE::fetch(lists.node, lists.block, child);
  }
  // Asks for what a ray a little further down a list will look at in this turn, where that was not asked for beforehand. It
  // pays where the second cache is large and the third one far (Emerald Rapids: a tenth of the bunny's diffuse rays), and
  // not on Zen 3.
  HWY_INLINE void fetch_ahead(const Lists& lists, const uint8_t* list, uint32_t at, uint32_t count) const {
    constexpr uint32_t kAhead = 10;
    if (kMasks && !lists.from_memory) HWY_NAMESPACE::fetch(lists.node, lists.block, child_[list[std::min(at + kAhead, count - 1)]]);
  }
  HWY_INLINE void go_to(Lists& lists, uint32_t ray, uint32_t child) {
    child_[ray] = child;
    at_node_[lists.nodes] = static_cast<uint8_t>(ray), lists.nodes += is_node(child);
    at_block_[lists.blocks] = static_cast<uint8_t>(ray), lists.blocks += is_block(child);
    fetch(lists, child);
  }
  HWY_INLINE void pop(Lists& lists, uint32_t ray, uint32_t top) {
    top_[ray] = --top;
    go_to(lists, ray, waiting_[ray].child[top]);
  }

  // What of the candidates is hit; their rays then go on.
  template <bool kShortens, class QueryOf>
  HWY_INLINE void decide(Lists& lists, uint32_t crossed_blocks, FrameRays& rays, QueryOf&& query_of) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < crossed_blocks; ++i) {
      const auto& [block, ray, found] = crossed_[i];
      uint32_t rest = found.some;
      do {
        const int lane = std::countr_zero(rest);
        candidate_[count++] = {block, static_cast<uint8_t>(lane), static_cast<uint8_t>(ray), (found.ties >> lane & 1) != 0,
                               (found.from_front >> lane & 1) != 0};
      } while (rest &= rest - 1);
    }
    uint64_t ended = 0, shortened = 0;
    for (uint32_t i = 0; i < count; i += Refined::kSize) {
      const uint32_t some = std::min<uint32_t>(Refined::kSize, count - i);
      for (uint32_t k = some; k < Refined::kSize; ++k) candidate_[i + k] = candidate_[i];
      Refined refined;
      refine(candidate_ + i, rays, refined);
      for (uint32_t rest = (refined.in_range | refined.rare) & ((1u << some) - 1); rest; rest &= rest - 1) {
        const int k = std::countr_zero(rest);
        const Candidate& c = candidate_[i + static_cast<uint32_t>(k)];
        auto query = query_of(c.ray);
        bool end;
        const double before = rays.t_max[c.ray];
        if (refined.rare >> k & 1) [[unlikely]] {
          end = offer(*c.block, c.lane, rays, c.ray, c.tie, c.from_front, query);
        } else {
          end = refined.t[k] <= before && query.take(rays, c.ray, c.block->face[c.lane], {refined.t[k], refined.u[k], refined.v[k], c.from_front});
        }
        ended |= uint64_t(end) << c.ray;
        shortened |= uint64_t(rays.t_max[c.ray] < before) << c.ray;
      }
    }
    for (uint32_t i = 0; i < crossed_blocks; ++i) {
      const uint32_t ray = crossed_[i].ray;
      if (ended >> ray & 1) continue;
      if (kShortens && (shortened >> ray & 1)) forget_beyond(ray, rays.s_max[ray]);
      pop(lists, ray, top_[ray]);
    }
  }

  // Puts the children that the ray meets on its stack, the nearest on top.
  template <bool kShortens>
  HWY_INLINE uint32_t enter_node(const WideNode& node, const FrameRays& rays, uint32_t ray) {
    const Floats d;
    const Words w;
    using V = hn::Vec<Floats>;
    auto plane = [&](uint32_t axis, uint32_t side) {  // side 0: the one that is met first
      return hn::MulSub(hn::Load(d, node.planes[0] + (rays.near_plane[axis][ray] ^ side)), hn::Set(d, rays.reciprocal[axis][ray]),
                        hn::Set(d, rays.scaled_origin[axis][ray]));
    };
    constexpr uint32_t kOther = WideNode::kWidth;
    const V near = hn::Max(hn::Max(plane(0, 0), plane(1, 0)), hn::Max(plane(2, 0), hn::Set(d, rays.s_min[ray])));
    const V far = hn::Min(hn::Min(plane(0, kOther), plane(1, kOther)), hn::Min(plane(2, kOther), hn::Set(d, rays.s_max[ray])));
    const uint32_t top = top_[ray];
    Waiting& waiting = waiting_[ray];
    const V children = hn::BitCast(d, hn::Load(w, node.child));
    if constexpr (kMasks) {  // compressed instead of looked up in a table
      const auto by_distance = hn::IndicesFromVec(d, hn::Xor(hn::Iota(w, 0), hn::Set(w, rays.octant[ray] ^ 7)));
      const V nears = hn::TableLookupLanes(near, by_distance), fars = hn::TableLookupLanes(far, by_distance);
      const auto met = hn::Le(nears, fars);
      hn::StoreU(hn::Compress(hn::TableLookupLanes(children, by_distance), met), d, reinterpret_cast<float*>(waiting.child + top));
      if constexpr (kShortens) hn::StoreU(hn::Compress(nears, met), d, waiting.near + top);
      return top + static_cast<uint32_t>(std::popcount(bits(d, met)));
    } else {
      const uint32_t met = bits(d, hn::Le(near, far));
      const auto slots = slots_of(kByDistance[rays.octant[ray] ^ 7][met]);
      hn::StoreU(hn::TableLookupLanes(children, slots), d, reinterpret_cast<float*>(waiting.child + top));
      if constexpr (kShortens) hn::StoreU(hn::TableLookupLanes(near, slots), d, waiting.near + top);
      return top + static_cast<uint32_t>(std::popcount(met));
    }
  }

  // Takes what is farther than s_max off a ray's stack.
  HWY_INLINE void forget_beyond(uint32_t ray, float s_max) {
    const Floats d;
    const Words w;
    Waiting& waiting = waiting_[ray];
    const uint32_t top = top_[ray];
    uint32_t kept = 0;
    for (uint32_t i = 0; i < top; i += WideNode::kWidth) {
      const auto near = hn::LoadU(d, waiting.near + i);
      const auto child = hn::LoadU(w, waiting.child + i);
      uint32_t keep = bits(d, hn::Le(near, hn::Set(d, s_max)));
      if (top - i < WideNode::kWidth) keep &= (1u << (top - i)) - 1;
      const auto slots = slots_of(kByDistance[0][keep]);
      hn::StoreU(hn::TableLookupLanes(near, slots), d, waiting.near + kept);
      hn::StoreU(hn::TableLookupLanes(hn::BitCast(d, child), slots), d, reinterpret_cast<float*>(waiting.child + kept));
      kept += static_cast<uint32_t>(std::popcount(keep));
    }
    top_[ray] = kept;
  }

  struct Waiting {
    uint32_t child[kMostWaiting + 2 * WideNode::kWidth];
    float near[kMostWaiting + 2 * WideNode::kWidth];
  };
  struct CrossedBlock {
    const TriangleBlock* block;
    uint32_t ray;
    Crossed found;
  };
  Waiting waiting_[kSize];
  uint32_t child_[kSize], top_[kSize];
  uint8_t at_node_[kSize + 1], at_block_[kSize + 1];
  CrossedBlock crossed_[kSize + 1];
  Candidate candidate_[kSize * WideNode::kWidth + Refined::kSize];
};

}  // namespace tilecast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
