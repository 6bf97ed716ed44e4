// Sixteen rays of one direction's kind, or 64, through a WideBvh together: nodes are entered by the interval that holds
// all of them (Reshetov, Soupikov and Hurley, "Multi-Level Ray Tracing Algorithm", TOG 24(3), 2005), and before a block is
// tested the rays that miss its box fall out. Sixteen that are less alike part on the way.
#if defined(TILECAST_WIDE_PACKET_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TILECAST_WIDE_PACKET_INL_H
#undef TILECAST_WIDE_PACKET_INL_H
#else
#define TILECAST_WIDE_PACKET_INL_H
#endif

#include "accel/wide_stream-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tilecast::HWY_NAMESPACE {

// So many rays of a packet at once: eight, or all sixteen.
using Together = hn::CappedTag<float, FrameRays::kPacket>;
constexpr int kAtOnce = hn::MaxLanes(Together());

// How far apart the rays are, in the frame's units, where they pass its centre and by the time they leave it: up to the
// first sixteen stay together, up to the second only while a node is met by at least kTogether of them.
constexpr float kNarrow = 0.05f, kWide = 0.5f;
constexpr int kTogether = 6;

// Rays go on together while the blocks that they come to are met by so many on average, and as many may fall short.
template <int kRays>
constexpr int kEnough = kRays == FrameRays::kPacket ? 1 : 2;
constexpr int kPatience = 32;

template <int kRays>  // as bits
constexpr uint64_t kAll = ~uint64_t(0) >> (64 - kRays);

struct PacketBounds {
  float origin_lo[3], origin_hi[3], reciprocal_lo[3], reciprocal_hi[3];
  uint32_t octant;
  bool one_shear;  // all along the same axes
  bool narrow;     // they do not part
  float s_min, s_max;
};

// False where the rays differ too much to be worth it.
template <int kRays>
HWY_INLINE bool bound(FrameRays& rays, int begin, uint64_t inside, PacketBounds& out) {
  const Together d;
  using V = hn::Vec<Together>;
  const int first = begin + std::countr_zero(inside);
  for (uint64_t rest = ~inside & kAll<kRays>; rest; rest &= rest - 1) rays.copy_lane(first, begin + std::countr_zero(rest));
  out.octant = rays.octant[first];
  auto all_alike = [&](const uint32_t* of) {
    const hn::RebindToUnsigned<Together> w;
    bool alike = true;
    for (int k = 0; k < kRays; k += kAtOnce) alike &= hn::AllTrue(w, hn::Eq(hn::Load(w, of + begin + k), hn::Set(w, of[first])));
    return alike;
  };
  if (!all_alike(rays.octant)) return false;
  out.one_shear = all_alike(reinterpret_cast<const uint32_t*>(rays.axes));
  auto extremes = [&](const float* values, float& lo, float& hi) {
    V least = hn::Load(d, values + begin), most = least;
    for (int k = kAtOnce; k < kRays; k += kAtOnce) {
      const V v = hn::Load(d, values + begin + k);
      least = hn::Min(least, v), most = hn::Max(most, v);
    }
    lo = hn::GetLane(hn::MinOfLanes(d, least)), hi = hn::GetLane(hn::MaxOfLanes(d, most));
  };
  float ignored, width = 0.0f;
  for (int axis = 0; axis < 3; ++axis) {
    extremes(rays.origin[axis], out.origin_lo[axis], out.origin_hi[axis]);
    extremes(rays.reciprocal[axis], out.reciprocal_lo[axis], out.reciprocal_hi[axis]);
    width = std::max(width, out.origin_hi[axis] - out.origin_lo[axis]);
    // 1 / a - 1 / b: how far the directions, whose largest component is between 1 and 2, part by the frame's other end.
    width = std::max(width, std::fabs(1.0f / out.reciprocal_hi[axis] - 1.0f / out.reciprocal_lo[axis]));
    if (!(width <= kWide)) return false;
  }
  out.narrow = kRays > FrameRays::kPacket || width <= kNarrow;
  extremes(rays.s_min, out.s_min, ignored);
  extremes(rays.s_max, ignored, out.s_max);
  return true;
}

// Slots of children that some of the rays may meet are pushed, with the node's number, the nearest on top.
HWY_INLINE int push_slots(const WideNode& node, uint32_t number, const PacketBounds& rays, uint32_t* slots, float* nears) {
  const Floats d;
  const Words w;
  using V = hn::Vec<Floats>;
  V near = hn::Set(d, rays.s_min), far = hn::Set(d, rays.s_max);
  for (int axis = 0; axis < 3; ++axis) {
    const uint32_t negative = rays.octant >> axis & 1;
    const float at_near = negative ? rays.origin_lo[axis] : rays.origin_hi[axis];
    const float at_far = negative ? rays.origin_hi[axis] : rays.origin_lo[axis];
    const V lo = hn::Set(d, rays.reciprocal_lo[axis]), hi = hn::Set(d, rays.reciprocal_hi[axis]);
    const V n = hn::Sub(hn::Load(d, node.planes[2 * axis + negative]), hn::Set(d, at_near));
    const V f = hn::Sub(hn::Load(d, node.planes[2 * axis + (negative ^ 1)]), hn::Set(d, at_far));
    near = hn::Max(near, hn::Min(hn::Mul(n, lo), hn::Mul(n, hi)));
    far = hn::Min(far, hn::Max(hn::Mul(f, lo), hn::Mul(f, hi)));
  }
  const uint32_t met = bits(d, hn::Le(near, far));
  const auto order = slots_of(kByDistance[rays.octant ^ 7][met]);
  const auto numbered = hn::BitCast(d, hn::Add(hn::Iota(w, 0), hn::Set(w, number * WideNode::kWidth)));
  hn::StoreU(hn::TableLookupLanes(numbered, order), d, reinterpret_cast<float*>(slots));
  hn::StoreU(hn::TableLookupLanes(near, order), d, nears);
  return std::popcount(met);
}

// Which of the rays meet a child's box.
template <int kRays>
HWY_INLINE uint64_t meeting(const WideNode& node, uint32_t slot, const FrameRays& rays, int first, uint32_t octant) {
  const Together d;
  using V = hn::Vec<Together>;
  uint64_t out = 0;
  for (int k = 0; k < kRays; k += kAtOnce) {
    const int begin = first + k;
    V near = hn::Load(d, rays.s_min + begin), far = hn::Load(d, rays.s_max + begin);
    for (int axis = 0; axis < 3; ++axis) {
      const uint32_t negative = octant >> axis & 1;
      const V reciprocal = hn::Load(d, rays.reciprocal[axis] + begin), origin = hn::Load(d, rays.scaled_origin[axis] + begin);
      near = hn::Max(near, hn::MulSub(hn::Set(d, node.planes[2 * axis + negative][slot]), reciprocal, origin));
      far = hn::Min(far, hn::MulSub(hn::Set(d, node.planes[2 * axis + (negative ^ 1)][slot]), reciprocal, origin));
    }
    out |= uint64_t(bits(d, hn::Le(near, far))) << k;
  }
  return out;
}

// A block's triangles, one after the other, against all rays of `active`, which have one shear; those that are at their
// end are taken out.
template <int kRays, class QueryOf>
HWY_INLINE void test_block(const TriangleBlock& block, int triangles, FrameRays& rays, int begin, uint64_t meeting, uint64_t& active, QueryOf&& query_of) {
  const Together d;
  using V = hn::Vec<Together>;
  const int first = begin + std::countr_zero(meeting);
  const uint8_t* axes = rays.axes[first];
  for (int lane = 0; lane < triangles; ++lane) {
    V vertices[3][3];
    for (int v = 0; v < 3; ++v)
      for (int i = 0; i < 3; ++i) vertices[v][i] = hn::Set(d, block.vertices[v][axes[i]][lane]);
    for (int part = 0; part < kRays; part += kAtOnce) {
      if ((meeting >> part & ((1u << kAtOnce) - 1)) == 0) continue;
      const int from = begin + part;
      V origin[3];
      for (int i = 0; i < 3; ++i) origin[i] = hn::Load(d, rays.swapped_origin[i] + from);
      const Crossed found = crossed(d, vertices, origin, hn::Load(d, rays.shear_x + from), hn::Load(d, rays.shear_y + from));
      for (uint32_t rest = found.some & static_cast<uint32_t>((meeting & active) >> part); rest; rest &= rest - 1) {
        const int k = std::countr_zero(rest), ray = from + k;
        auto query = query_of(ray);
        if (offer(block, lane, rays, ray, found.ties >> k & 1, found.from_front >> k & 1, query)) active &= ~(uint64_t(1) << (part + k));
      }
    }
  }
}

// What is left to do for single rays, as bits, and, of sixteen, begun in `stream`; query_of(ray) is what is wanted of each.
// They may begin anew: what they have found only shortens their way. `from_memory`: the cache does not keep the hierarchy.
template <int kRays, class QueryOf>
HWY_INLINE uint64_t trace_packet(const WideBvh& bvh, bool from_memory, FrameRays& rays, int begin, Stream& stream, QueryOf&& query_of) {
  PacketBounds bounds;
  const uint64_t inside = rays.inside >> begin & kAll<kRays>;
  auto from_root = [&](uint64_t which) {
    if constexpr (kRays > FrameRays::kPacket) return which;
    for (uint64_t rest = which; rest; rest &= rest - 1) {
      const int ray = begin + std::countr_zero(rest);
      stream.begin(ray), stream.push(ray, bvh.root(), -FrameBox::kFar);
    }
    return which;
  };
  if ((bvh.root() & WideNode::kLeaf) || std::popcount(inside) < kRays / 4 || !bound<kRays>(rays, begin, inside, bounds)) return from_root(inside);
  using Query = decltype(query_of(0));
  const WideNode* nodes = bvh.nodes().data();
  const TriangleBlock* blocks = bvh.blocks().data();
  const Together d;
  uint32_t slots[WideBvh::kStackSize];
  float nears[WideBvh::kStackSize];
  struct Apart {  // what few rays meet
    uint32_t child, met;
    float near;
  } apart[Stream::kMostPushed];
  int count_apart = 0;
  uint64_t active = inside;
  int patience = kPatience;
  int top = push_slots(nodes[0], 0, bounds, slots, nears);
  while (top > 0) {
    --top;
    if (Query::kShortens && nears[top] > bounds.s_max) continue;
    const WideNode& parent = nodes[slots[top] / WideNode::kWidth];
    const uint32_t slot = slots[top] % WideNode::kWidth, child = parent.child[slot];
    const bool is_node = !(child & WideNode::kLeaf);
    uint64_t met = 0;
    if (!is_node || !bounds.narrow) {
      met = meeting<kRays>(parent, slot, rays, begin, bounds.octant) & active;
      const int count = std::popcount(met);
      if (bounds.narrow) {
        if ((patience += count - kEnough<kRays>) < 0) return from_root(active);
        if (met == 0) continue;
      } else if (count < kTogether) {
        if (count_apart == Stream::kMostPushed) return from_root(active);
        apart[count_apart] = {child, static_cast<uint32_t>(met), nears[top]};
        count_apart += met != 0;
        continue;
      }
    }
    if (is_node) {
      const int before = top;
      top += push_slots(nodes[child], child, bounds, slots + top, nears + top);
      for (int i = top; from_memory && i > before; --i) fetch(nodes, blocks, nodes[child].child[slots[i - 1] % WideNode::kWidth]);
      continue;
    }
    const TriangleBlock& block = blocks[child & ~WideNode::kLeaf];
    const int triangles = triangles_of(block);
    if (bounds.one_shear && std::popcount(met) > triangles) {
      test_block<kRays>(block, triangles, rays, begin, met, active, query_of);
    } else {
      for (uint64_t rest = met; rest; rest &= rest - 1) {
        const int k = std::countr_zero(rest), ray = begin + k;
        if (test_block(block, RayLanes(rays, ray), rays, ray, query_of(ray))) active &= ~(uint64_t(1) << k);
      }
    }
    if (active == 0) return 0;
    if constexpr (!Query::kShortens) continue;
    // Rays that repeat another do not hold the packet back.
    for (uint64_t rest = ~inside & kAll<kRays>; rest; rest &= rest - 1) rays.s_max[begin + std::countr_zero(rest)] = rays.s_min[begin];
    auto farthest = hn::Load(d, rays.s_max + begin);
    for (int k = kAtOnce; k < kRays; k += kAtOnce) farthest = hn::Max(farthest, hn::Load(d, rays.s_max + begin + k));
    bounds.s_max = hn::GetLane(hn::MaxOfLanes(d, farthest));
  }
  if (count_apart == 0) return 0;
  for (uint64_t rest = active; rest; rest &= rest - 1) stream.begin(begin + std::countr_zero(rest));
  while (count_apart > 0) {
    const Apart& of = apart[--count_apart];
    for (uint64_t rest = of.met & active; rest; rest &= rest - 1) stream.push(begin + std::countr_zero(rest), of.child, of.near);
  }
  return active;
}

// All rays that are in the frame at once; those that are left are as before. In a function of its own: in one with packets
// of sixteen, both were slower (terrain's primary rays by a sixth).
template <class QueryOf>
HWY_NOINLINE uint64_t trace_group(const WideBvh& bvh, bool from_memory, FrameRays& rays, Stream& stream, QueryOf&& query_of) {
  return trace_packet<FrameRays::kSize>(bvh, from_memory, rays, 0, stream, query_of);
}

}  // namespace tilecast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
