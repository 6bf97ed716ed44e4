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

// What is wanted of the hits. take() is given every hit in t_min < t <= t_max, lowers the ray's t_max where kShortens says
// so, and ends the search by returning true.
struct Closest {
  static constexpr bool kShortens = true;
  FaceHit& best;  // by (t, face)
  bool take(FrameRays& rays, int ray, uint32_t face, const TriangleHit& hit) {
    if (hit.t == rays.t_max[ray] && best.face < face) return false;
    best = {hit.t, hit.u, hit.v, face, hit.entering};
    rays.lower_t_max(ray, hit.t);
    return false;
  }
};
struct Any {
  static constexpr bool kShortens = false;
  uint32_t& face;
  bool take(FrameRays&, int, uint32_t of, const TriangleHit&) {
    face = of;
    return true;
  }
};
struct All {
  static constexpr bool kShortens = false;
  std::vector<FaceHit>& hits;
  bool take(FrameRays&, int, uint32_t face, const TriangleHit& hit) {
    hits.push_back({hit.t, hit.u, hit.v, face, hit.entering});
    return false;
  }
};

// For each octant that a direction does not have (its own, inverted) and each mask of slots: the slots from far to near,
// three bits each, and above them the nearest. (hn::Compress copies its table at every call.)
constexpr uint32_t kNearest = 24;
inline constexpr auto kByDistance = [] {
  std::array<std::array<uint32_t, 256>, 8> table{};
  for (uint32_t octant = 0; octant < 8; ++octant)
    for (uint32_t mask = 0; mask < 256; ++mask) {
      uint32_t slots = 0, nearest = 0;
      for (uint32_t distance = 0, n = 0; distance < 8; ++distance) {  // bit 7 is the nearest
        const uint32_t slot = distance ^ octant;
        if (mask >> slot & 1) slots |= slot << 3 * n++, nearest = slot;
      }
      table[octant][mask] = slots | nearest << kNearest;
    }
  return table;
}();

// How many triangles a block has, without a branch.
HWY_INLINE int triangles_of(const TriangleBlock& block) {
  const Words w;
  return std::popcount(bits(w, hn::Ne(hn::Load(w, block.face), hn::Set(w, TriangleBlock::kNone))));
}

// Asks for a node or block that is looked at soon.
HWY_INLINE void fetch(const WideNode* nodes, const TriangleBlock* blocks, uint32_t child) {
  const char* at = child & WideNode::kLeaf ? reinterpret_cast<const char*>(blocks + (child & ~WideNode::kLeaf))
                                           : reinterpret_cast<const char*>(nodes + child);
  for (size_t i = 0; i < sizeof(TriangleBlock); i += 64) __builtin_prefetch(at + i);
}

// An entry's slots from far to near, as lanes.
HWY_INLINE auto slots_of(uint32_t by_distance) {
  const Words w;
  alignas(32) static constexpr uint32_t kShifts[8] = {0, 3, 6, 9, 12, 15, 18, 21};
  return hn::IndicesFromVec(Floats(), hn::And(hn::Shr(hn::Set(w, by_distance), hn::Load(w, kShifts)), hn::Set(w, 7)));
}

// Triangles against rays, lane by lane: which may be crossed, from the front, and which of them need the tie-break. All are
// sheared by the same axes.
struct Crossed {
  uint32_t some, from_front, ties;
};
template <class D, class V>
HWY_INLINE Crossed crossed(D d, const V vertices[3][3], const V origin[3], V shear_x, V shear_y) {
  V x[3], y[3];  // all negative, which changes no bit of a determinant: so vertices are taken from memory
  for (int v = 0; v < 3; ++v) {
    const V along = hn::Sub(origin[2], vertices[v][2]);
    x[v] = hn::NegMulAdd(shear_x, along, hn::Sub(origin[0], vertices[v][0]));
    y[v] = hn::NegMulAdd(shear_y, along, hn::Sub(origin[1], vertices[v][1]));
  }
  auto determinant = [&](int p, int q) {  // x[p] * y[q] - y[p] * x[q], as base/exact.h does it
    const V product = hn::Mul(y[p], x[q]);
    return hn::Add(hn::MulSub(x[p], y[q], product), hn::NegMulAdd(y[p], x[q], product));
  };
  const V a = determinant(1, 2), b = determinant(2, 0), c = determinant(0, 1);
  const V least = hn::Min(hn::Min(a, b), c), most = hn::Max(hn::Max(a, b), c), zero = hn::Zero(d);
  // Unused lanes are not a number: neither below nor above zero.
  const uint32_t some = bits(d, hn::Or(hn::Ge(least, zero), hn::Le(most, zero)));
  const uint32_t outwards = bits(d, hn::Gt(least, zero)), inwards = bits(d, hn::Lt(most, zero));
  return {some, inwards, some & ~(outwards | inwards)};
}

// One triangle and ray that may cross, in double. True where the search is at its end.
template <class Query>
HWY_INLINE bool offer(const TriangleBlock& block, int lane, FrameRays& rays, int ray, bool tie, bool from_front, Query& query) {
  const uint8_t x = rays.axes[ray][0], y = rays.axes[ray][1], z = rays.axes[ray][2];
  float vertices[3][3];
  for (int v = 0; v < 3; ++v)
    vertices[v][0] = block.vertices[v][x][lane], vertices[v][1] = block.vertices[v][y][lane], vertices[v][2] = block.vertices[v][z][lane];
  if (tie) [[unlikely]] {
    const float origin[3] = {rays.swapped_origin[0][ray], rays.swapped_origin[1][ray], rays.swapped_origin[2][ray]};
    const int side = crossed_side(origin, rays.shear_x[ray], rays.shear_y[ray], vertices);
    if (side == 0) return false;
    from_front = side < 0;
  }
  const TriangleHit hit = refine(rays.sheared(ray), vertices, from_front);
  return hit.t > rays.t_min[ray] && hit.t <= rays.t_max[ray] && query.take(rays, ray, block.face[lane], hit);
}

// What blocks want to know of a ray, in all lanes.
struct RayLanes {
  using V = hn::Vec<Floats>;
  HWY_INLINE RayLanes(const FrameRays& rays, int ray)
      : axes{rays.axes[ray][0], rays.axes[ray][1], rays.axes[ray][2]}, shear_x(hn::Set(Floats(), rays.shear_x[ray])),
        shear_y(hn::Set(Floats(), rays.shear_y[ray])) {
    for (int i = 0; i < 3; ++i) origin[i] = hn::Set(Floats(), rays.swapped_origin[i][ray]);
  }
  // A block's triangles against the ray.
  HWY_INLINE Crossed crossed(const TriangleBlock& block) const {
    V vertices[3][3];
    for (int v = 0; v < 3; ++v)
      for (int i = 0; i < 3; ++i) vertices[v][i] = hn::Load(Floats(), block.vertices[v][axes[i]]);
    return HWY_NAMESPACE::crossed(Floats(), vertices, origin, shear_x, shear_y);
  }

  size_t axes[3];  // as in FrameRay
  V origin[3], shear_x, shear_y;
};

// A block's triangles against one ray. True where the search is at its end.
template <class Query>
HWY_INLINE bool test_block(const TriangleBlock& block, const RayLanes& lanes, FrameRays& rays, int ray, Query query) {
  const Crossed found = lanes.crossed(block);
  for (uint32_t rest = found.some; rest; rest &= rest - 1) {
    const int lane = std::countr_zero(rest);
    if (offer(block, lane, rays, ray, found.ties >> lane & 1, found.from_front >> lane & 1, query)) return true;
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
  const uint32_t octant = rays.octant[ray];
  const auto& by_distance = kByDistance[octant ^ 7];
  const RayLanes lanes(rays, ray);
  const V reciprocal[3] = {hn::Set(d, rays.reciprocal[0][ray]), hn::Set(d, rays.reciprocal[1][ray]), hn::Set(d, rays.reciprocal[2][ray])};
  const V origin[3] = {hn::Set(d, rays.scaled_origin[0][ray]), hn::Set(d, rays.scaled_origin[1][ray]), hn::Set(d, rays.scaled_origin[2][ray])};
  const V s_min = hn::Set(d, rays.s_min[ray]);
  V s_max = hn::Set(d, rays.s_max[ray]);
  uint32_t near_plane[3];
  for (int axis = 0; axis < 3; ++axis) near_plane[axis] = 2 * axis + (octant >> axis & 1);

  uint32_t children[WideBvh::kStackSize];
  float nears[Query::kShortens ? WideBvh::kStackSize : 1];
  int top = 0;
  uint32_t child = bvh.root();
  auto pop = [&] {  // false where nothing waits
    do {
      if (top == 0) return false;
      --top;
    } while (Query::kShortens && nears[top] > rays.s_max[ray]);
    child = children[top];
    return true;
  };
  for (;;) {
    cost.step();
    if (child & WideNode::kLeaf) {
      const TriangleBlock& block = blocks[child & ~WideNode::kLeaf];
      if constexpr (!std::is_same_v<Cost, NoCost>) cost.test(static_cast<uint64_t>(triangles_of(block)));
      if (test_block(block, lanes, rays, ray, query) || !pop()) return;
      if constexpr (Query::kShortens) s_max = hn::Set(d, rays.s_max[ray]);
      continue;
    }
    const WideNode& node = nodes[child];
    auto plane = [&](int axis, uint32_t side) {  // side 0: the one that is met first
      return hn::MulSub(hn::Load(d, node.planes[near_plane[axis] ^ side]), reciprocal[axis], origin[axis]);
    };
    const V near = hn::Max(hn::Max(plane(0, 0), plane(1, 0)), hn::Max(plane(2, 0), s_min));
    const V far = hn::Min(hn::Min(plane(0, 1), plane(1, 1)), hn::Min(plane(2, 1), s_max));
    const uint32_t met = bits(d, hn::Le(near, far));
    if (met == 0) {
      if (!pop()) return;
      continue;
    }
    // The nearest is gone to at once; the others wait.
    child = node.child[by_distance[met] >> kNearest];
    const auto slots = slots_of(by_distance[met]);
    hn::StoreU(hn::TableLookupLanes(hn::BitCast(d, hn::Load(w, node.child)), slots), d, reinterpret_cast<float*>(children + top));
    if constexpr (Query::kShortens) hn::StoreU(hn::TableLookupLanes(near, slots), d, nears + top);
    top += std::popcount(met) - 1;
  }
}

}  // namespace tilecast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
