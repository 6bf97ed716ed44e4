// Rays through a WideBvh, each on its own.
#if defined(TILECAST_WIDE_KERNEL_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TILECAST_WIDE_KERNEL_INL_H
#undef TILECAST_WIDE_KERNEL_INL_H
#else
#define TILECAST_WIDE_KERNEL_INL_H
#endif

#include <array>
#include <bit>

#include <hwy/highway.h>

#include "accel/wide_rays-inl.h"
#include "accel/wide_trace.h"

HWY_BEFORE_NAMESPACE();
namespace tilecast::HWY_NAMESPACE {

using Floats = hn::FixedTag<float, WideNode::kWidth>;
using Words = hn::FixedTag<uint32_t, WideNode::kWidth>;

// What is wanted of the hits. take() is given every hit in t_min < t <= t_max, may lower the ray's t_max, and ends the
// search by returning true.
struct Closest {
  FaceHit& best;  // by (t, face)
  bool take(FrameRays& rays, int ray, uint32_t face, const TriangleHit& hit) {
    if (hit.t == rays.t_max[ray] && best.face < face) return false;
    best = {hit.t, hit.u, hit.v, face, hit.entering};
    rays.lower_t_max(ray, hit.t);
    return false;
  }
};
struct Any {
  uint32_t& face;
  bool take(FrameRays&, int, uint32_t of, const TriangleHit&) {
    face = of;
    return true;
  }
};
struct All {
  std::vector<FaceHit>& hits;
  bool take(FrameRays&, int, uint32_t face, const TriangleHit& hit) {
    hits.push_back({hit.t, hit.u, hit.v, face, hit.entering});
    return false;
  }
};

// For each mask of eight lanes, the lanes that are set, three bits each: hn::Compress copies its table at every call.
inline constexpr auto kSetLanes = [] {
  std::array<uint32_t, 256> table{};
  for (uint32_t mask = 0; mask < 256; ++mask)
    for (uint32_t lane = 0, n = 0; lane < 8; ++lane)
      if (mask >> lane & 1) table[mask] |= lane << 3 * n++;
  return table;
}();

// For each octant that a direction does not have (its own, inverted) and each mask of slots, the mask by how near the
// slots are, the farthest in bit 0.
inline constexpr auto kByDistance = [] {
  std::array<std::array<uint8_t, 256>, 8> table{};
  for (uint32_t octant = 0; octant < 8; ++octant)
    for (uint32_t mask = 0; mask < 256; ++mask)
      for (uint32_t slot = 0; slot < 8; ++slot)
        if (mask >> slot & 1) table[octant][mask] |= static_cast<uint8_t>(1u << (slot ^ octant));
  return table;
}();

// The slots of a mask by distance, from far to near.
HWY_INLINE auto slots_of(uint32_t by_distance, uint32_t inverted_octant) {
  const Words w;
  alignas(32) static constexpr uint32_t kShifts[8] = {0, 3, 6, 9, 12, 15, 18, 21};
  const auto lanes = hn::Xor(hn::Shr(hn::Set(w, kSetLanes[by_distance]), hn::Load(w, kShifts)), hn::Set(w, inverted_octant));
  return hn::IndicesFromVec(Floats(), hn::And(lanes, hn::Set(w, 7)));
}

// True where the search is at its end.
template <class Query>
HWY_INLINE bool test_block(const TriangleBlock& block, FrameRays& rays, int ray, Query query) {
  const Floats d;
  using V = hn::Vec<Floats>;
  const int x = rays.x[ray], y = rays.y[ray], z = rays.z[ray];
  const V ox = hn::Set(d, rays.origin[x][ray]), oy = hn::Set(d, rays.origin[y][ray]), oz = hn::Set(d, rays.origin[z][ray]);
  const V shear_x = hn::Set(d, rays.shear_x[ray]), shear_y = hn::Set(d, rays.shear_y[ray]);
  auto sheared_x = [&](int v, V along) { return hn::NegMulAdd(shear_x, along, hn::Sub(hn::Load(d, block.vertices[v][x]), ox)); };
  auto sheared_y = [&](int v, V along) { return hn::NegMulAdd(shear_y, along, hn::Sub(hn::Load(d, block.vertices[v][y]), oy)); };
  const V az = hn::Sub(hn::Load(d, block.vertices[0][z]), oz);
  const V bz = hn::Sub(hn::Load(d, block.vertices[1][z]), oz);
  const V cz = hn::Sub(hn::Load(d, block.vertices[2][z]), oz);
  const V ax = sheared_x(0, az), bx = sheared_x(1, bz), cx = sheared_x(2, cz);
  const V ay = sheared_y(0, az), by = sheared_y(1, bz), cy = sheared_y(2, cz);
  auto determinant = [&](V px, V py, V qx, V qy) {  // px * qy - py * qx, as base/exact.h does it
    V p = hn::Mul(py, qx);
    return hn::Add(hn::MulSub(px, qy, p), hn::NegMulAdd(py, qx, p));
  };
  const V ea = determinant(bx, by, cx, cy), eb = determinant(cx, cy, ax, ay), ec = determinant(ax, ay, bx, by);
  const V least = hn::Min(hn::Min(ea, eb), ec), most = hn::Max(hn::Max(ea, eb), ec), zero = hn::Zero(d);
  // Unused lanes are not a number: neither below nor above zero.
  const auto inwards = hn::Lt(most, zero);
  uint32_t inside = bits(d, hn::Or(hn::Gt(least, zero), inwards));
  const uint32_t entering = bits(d, inwards);
  const auto touching = hn::Or(hn::Eq(ea, zero), hn::Or(hn::Eq(eb, zero), hn::Eq(ec, zero)));
  uint32_t ties = bits(d, hn::And(touching, hn::And(hn::Le(least, zero), hn::Ge(most, zero))));
  if (!(inside | ties)) return false;
  const ShearedLine line = rays.sheared(ray);
  auto offer = [&](int lane, const TriangleHit& hit) {
    return hit.t > rays.t_min[ray] && hit.t <= rays.t_max[ray] && query.take(rays, ray, block.face[lane], hit);
  };
  for (; inside; inside &= inside - 1) {
    const int lane = std::countr_zero(inside);
    float vertices[3][3];
    for (int v = 0; v < 3; ++v)
      vertices[v][0] = block.vertices[v][x][lane], vertices[v][1] = block.vertices[v][y][lane], vertices[v][2] = block.vertices[v][z][lane];
    if (offer(lane, refine(line, vertices, entering >> lane & 1))) return true;
  }
  for (; ties; ties &= ties - 1) {
    const int lane = std::countr_zero(ties);
    TriangleHit hit;
    if (intersect(rays.line(ray), block.triangle(lane), hit) && offer(lane, hit)) return true;
  }
  return false;
}

// One ray, from the root.
template <class Query, class Cost>
HWY_INLINE void trace(const WideBvh& bvh, FrameRays& rays, int ray, Query query, Cost& cost) {
  const Floats d;
  const Words w;
  using V = hn::Vec<Floats>;
  const WideNode* nodes = bvh.nodes().data();
  const TriangleBlock* blocks = bvh.blocks().data();
  const uint32_t octant = rays.octant[ray], inverted = octant ^ 7;
  const V reciprocal[3] = {hn::Set(d, rays.reciprocal[0][ray]), hn::Set(d, rays.reciprocal[1][ray]), hn::Set(d, rays.reciprocal[2][ray])};
  const V origin[3] = {hn::Set(d, rays.scaled_origin[0][ray]), hn::Set(d, rays.scaled_origin[1][ray]), hn::Set(d, rays.scaled_origin[2][ray])};
  const V s_min = hn::Set(d, rays.s_min[ray]);
  V s_max = hn::Set(d, rays.s_max[ray]);
  uint32_t near_plane[3];
  for (int axis = 0; axis < 3; ++axis) near_plane[axis] = 2 * axis + (octant >> axis & 1);

  uint32_t children[WideBvh::kStackSize];
  float nears[WideBvh::kStackSize];
  int top = 0;
  uint32_t child = bvh.root();
  for (;;) {
    while (!(child & WideNode::kLeaf)) {
      const WideNode& node = nodes[child];
      cost.step();
      auto plane = [&](int axis, uint32_t side) {  // side 0: the one that is met first
        return hn::MulSub(hn::Load(d, node.planes[near_plane[axis] ^ side]), reciprocal[axis], origin[axis]);
      };
      const V near = hn::Max(hn::Max(plane(0, 0), plane(1, 0)), hn::Max(plane(2, 0), s_min));
      const V far = hn::Min(hn::Min(plane(0, 1), plane(1, 1)), hn::Min(plane(2, 1), s_max));
      const uint32_t met = kByDistance[inverted][bits(d, hn::Le(near, far))];
      if (met == 0) goto pop;
      // The nearest is gone to at once; the others wait.
      child = node.child[static_cast<uint32_t>(std::bit_width(met) - 1) ^ inverted];
      const auto slots = slots_of(met, inverted);
      hn::StoreU(hn::TableLookupLanes(hn::BitCast(d, hn::Load(w, node.child)), slots), d, reinterpret_cast<float*>(children + top));
      hn::StoreU(hn::TableLookupLanes(near, slots), d, nears + top);
      top += std::popcount(met) - 1;
    }
    cost.step();
    cost.test();
    if (test_block(blocks[child & ~WideNode::kLeaf], rays, ray, query)) return;
    s_max = hn::Set(d, rays.s_max[ray]);
  pop:
    do {
      if (top == 0) return;
      --top;
    } while (nears[top] > rays.s_max[ray]);
    child = children[top];
  }
}

}  // namespace tilecast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
