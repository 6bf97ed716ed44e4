// Rays brought into a frame at once: bit for bit what enter_frame (base/frame.h) does with each.
#if defined(TILECAST_WIDE_RAYS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TILECAST_WIDE_RAYS_INL_H
#undef TILECAST_WIDE_RAYS_INL_H
#else
#define TILECAST_WIDE_RAYS_INL_H
#endif

#include <cstring>

#include <hwy/highway.h>

#include "accel/wide_bvh.h"
#include "geometry/triangle.h"

HWY_BEFORE_NAMESPACE();
namespace tilecast::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// AVX-512: masks of their own, and sixteen floats at once.
constexpr bool kMasks = HWY_TARGET <= HWY_AVX3;

// At most sixteen lanes' answers, as bits.
template <class D, class M>
HWY_INLINE uint32_t bits(D d, M mask) {
  std::conditional_t<(hn::MaxLanes(D()) > 8), uint16_t, uint8_t> out;
  uint8_t bytes[8];
  hn::StoreMaskBits(d, mask, bytes);
  std::memcpy(&out, bytes, sizeof out);
  return out;
}

struct alignas(64) FrameRays {
  static constexpr int kSize = 64;
  static constexpr int kPacket = 16;  // neighbours that may go together

  float origin[3][kSize], reciprocal[3][kSize];
  float scaled_origin[3][kSize];  // origin * reciprocal
  float shear_x[kSize], shear_y[kSize];
  float swapped_origin[3][kSize];    // origin in the order x, y, z
  uint32_t near_plane[3][kSize];     // where in WideNode::planes the first plane of each axis stands that the ray meets
  float s_min[kSize], s_max[kSize];  // s_max goes down with the hits
  double origin64[3][kSize], direction64[3][kSize];  // before rounding
  double t_start[kSize], t_scale[kSize], s_scale[kSize];  // t = (t_start + s) * t_scale, s_scale = 1 / t_scale
  double t_min[kSize], t_max[kSize];
  uint32_t octant[kSize];     // bit i: component i of the direction is negative
  uint8_t axes[kSize][4];     // x, y and z, as in FrameRay
  uint64_t inside;            // bit i: line i may meet the frame's content

  // Lane 0 alone.
  FrameRays() = default;
  FrameRays(const FrameRay& from, double from_t_min, double from_t_max) {
    inside = 1;
    octant[0] = 0;
    for (uint32_t axis = 0; axis < 3; ++axis) {
      origin[axis][0] = from.origin[axis], reciprocal[axis][0] = from.reciprocal[axis];
      scaled_origin[axis][0] = from.origin[axis] * from.reciprocal[axis];
      octant[0] |= static_cast<uint32_t>(std::signbit(from.reciprocal[axis])) << axis;
      near_plane[axis][0] = WideNode::kWidth * (2 * axis + (octant[0] >> axis & 1));
    }
    for (int i = 0; i < 3; ++i) origin64[i][0] = from.origin64[i], direction64[i][0] = from.direction64[i];
    shear_x[0] = from.shear_x, shear_y[0] = from.shear_y;
    swapped_origin[0][0] = from.origin[from.x], swapped_origin[1][0] = from.origin[from.y], swapped_origin[2][0] = from.origin[from.z];
    axes[0][0] = static_cast<uint8_t>(from.x), axes[0][1] = static_cast<uint8_t>(from.y), axes[0][2] = static_cast<uint8_t>(from.z);
    t_start[0] = from.t_start, t_scale[0] = from.t_scale, s_scale[0] = from.s_scale;
    t_min[0] = from_t_min, t_max[0] = from_t_max;
    s_min[0] = from.s_below(from_t_min), s_max[0] = from.s_above(from_t_max);
  }

  ShearedLine sheared(int i) const {
    const uint8_t x = axes[i][0], y = axes[i][1], z = axes[i][2];
    const double along = direction64[z][i];
    return {{origin64[x][i], origin64[y][i], origin64[z][i]}, direction64[x][i] / along, direction64[y][i] / along, along, t_start[i], t_scale[i]};
  }

  // What box tests look at.
  void copy_lane(int from, int to) {
    for (int axis = 0; axis < 3; ++axis) {
      origin[axis][to] = origin[axis][from];
      reciprocal[axis][to] = reciprocal[axis][from];
      scaled_origin[axis][to] = scaled_origin[axis][from];
    }
    s_min[to] = s_min[from], s_max[to] = s_max[from], octant[to] = octant[from];
    shear_x[to] = shear_x[from], shear_y[to] = shear_y[from];
    for (auto& origins : swapped_origin) origins[to] = origins[from];
    std::copy_n(axes[from], 4, axes[to]);
  }

  void lower_t_max(int i, double t) {
    t_max[i] = t;
    float s = static_cast<float>(t * s_scale[i] - t_start[i]);
    s_max[i] = s + std::fabs(s) * 0x1p-22f + static_cast<float>(std::fabs(t_start[i]) * 0x1p-50);
  }
};

// What is done in double goes by so many rays at once: four or eight.
using Doubles = hn::CappedTag<double, 8>;
constexpr int kDoubles = hn::MaxLanes(Doubles());

// So many rays' numbers, each as a vector, in the order that they stand in a ray.
template <class V>
HWY_INLINE void load_columns(const Ray* const rays[kDoubles], V out[8]) {
  static_assert(sizeof(Ray) == 8 * sizeof(double));
  const Doubles d;
  const hn::FixedTag<double, 2> pair;
  for (int i = 0; i < 8; i += 2) {
    auto pairs = [&](int first) {  // of every other ray
      auto two = [&](int k) {
        auto of = [&](int ray) { return hn::LoadU(pair, reinterpret_cast<const double*>(rays[ray]) + i); };
        return hn::Combine(hn::FixedTag<double, 4>(), of(k + 2), of(k));
      };
      if constexpr (kDoubles == 8) return hn::Combine(d, two(first + 4), two(first));
      else return two(first);
    };
    const V even = pairs(0), odd = pairs(1);
    out[i] = hn::InterleaveLower(d, even, odd), out[i + 1] = hn::InterleaveUpper(d, even, odd);
  }
}

// The axes x, y and z of a FrameRay, a byte each, where z is the first one (1), the second (2) or the third (0), 4 more:
// backwards.
alignas(32) inline constexpr uint32_t kAxes[8] = {0x020100, 0x000201, 0x010002, 0, 0x020001, 0x000102, 0x010200, 0};

// At most kSize rays. Lanes beyond `count` repeat the last ray and are not inside.
HWY_INLINE void enter_frame(const Frame& frame, const Ray* const* rays, int count, FrameRays& out) {
  const Doubles d;
  const hn::RebindToSigned<Doubles> d_bits;
  const hn::Rebind<float, Doubles> f;
  const hn::RebindToUnsigned<decltype(f)> f_bits;
  using V = hn::Vec<decltype(d)>;
  auto dot = [](const V* a, const V* b) { return hn::Add(hn::Add(hn::Mul(a[0], b[0]), hn::Mul(a[1], b[1])), hn::Mul(a[2], b[2])); };
  auto demoted_to_grid = [&](V v) {
    return hn::DemoteTo(f, hn::Mul(hn::Round(hn::Mul(v, hn::Set(d, 1.0 / kGrid))), hn::Set(d, kGrid)));
  };
  out.inside = 0;
  for (int begin = 0; begin < count; begin += kDoubles) {
    const Ray* r[kDoubles];
    for (int k = 0; k < kDoubles; ++k) r[k] = rays[std::min(begin + k, count - 1)];
    V columns[8];
    load_columns(r, columns);
    V origin[3], direction[3], start[3];
    for (int i = 0; i < 3; ++i) {
      origin[i] = hn::Mul(hn::Sub(columns[i], hn::Set(d, frame.centre[i])), hn::Set(d, frame.per_metre));
      direction[i] = columns[3 + i];
    }
    const V largest = hn::Max(hn::Max(hn::Abs(direction[0]), hn::Abs(direction[1])), hn::Abs(direction[2]));
    const auto finite = hn::And(hn::Ge(largest, hn::Set(d, 0x1p-1000)), hn::Le(largest, hn::Set(d, 0x1p1000)));
    const auto exponent = hn::And(hn::BitCast(d_bits, largest), hn::Set(d_bits, int64_t(0x7ff) << 52));
    const V normalise = hn::BitCast(d, hn::Sub(hn::Set(d_bits, int64_t(0x7fe) << 52), exponent));
    for (int i = 0; i < 3; ++i) direction[i] = hn::Mul(direction[i], normalise);
    const V t_start = hn::Div(hn::Neg(dot(origin, direction)), dot(direction, direction));
    const V t_scale = hn::Mul(hn::Set(d, frame.scale), normalise);
    for (int i = 0; i < 3; ++i) start[i] = hn::Add(origin[i], hn::Mul(t_start, direction[i]));
    // Content lies within sqrt(3) of the centre; a comparison with NaN is false.
    const auto inside = hn::And(finite, hn::Le(dot(start, start), hn::Set(d, 4.0)));

    using F = hn::Vec<decltype(f)>;
    F rounded[3], rounded_start[3];  // directions and starts
    auto octant = hn::Zero(f_bits);
    for (int i = 0; i < 3; ++i) {
      const auto o = demoted_to_grid(start[i]), dir = demoted_to_grid(direction[i]);
      const auto least = hn::Set(f, 0x1p-40f);
      const auto reciprocal = hn::Div(hn::Set(f, 1.0f), hn::IfThenElse(hn::Lt(hn::Abs(dir), least), hn::CopySign(least, dir), dir));
      rounded[i] = dir, rounded_start[i] = o;
      const auto negative = hn::ShiftRight<31>(hn::BitCast(f_bits, reciprocal));
      octant = hn::Or(octant, hn::ShiftLeftSame(negative, i));
      const auto near_plane = hn::Add(hn::Set(f_bits, 2 * WideNode::kWidth * i), hn::ShiftLeft<3>(negative));
      static_assert(WideNode::kWidth == 8);
      hn::Store(near_plane, f_bits, out.near_plane[i] + begin);
      hn::Store(o, f, out.origin[i] + begin);
      hn::Store(reciprocal, f, out.reciprocal[i] + begin);
      hn::Store(hn::Mul(o, reciprocal), f, out.scaled_origin[i] + begin);
      hn::Store(start[i], d, out.origin64[i] + begin);
      hn::Store(direction[i], d, out.direction64[i] + begin);
    }
    hn::Store(octant, f_bits, out.octant + begin);

    const V size[3] = {hn::Abs(direction[0]), hn::Abs(direction[1]), hn::Abs(direction[2])};
    const auto z_is_x = hn::And(hn::Ge(size[0], size[1]), hn::Ge(size[0], size[2]));
    const auto z_is_y = hn::And(hn::Lt(size[0], size[1]), hn::Ge(size[1], size[2]));
    const hn::RebindToUnsigned<Doubles> d_words;
    auto number = [&](uint64_t n) { return hn::BitCast(d, hn::Set(d_words, n)); };
    const auto z_axis = hn::TruncateTo(f_bits, hn::BitCast(d_words, hn::IfThenElse(z_is_x, number(1), hn::IfThenElseZero(z_is_y, number(2)))));
    const auto first = hn::RebindMask(f, hn::Eq(z_axis, hn::Set(f_bits, 1))), second = hn::RebindMask(f, hn::Eq(z_axis, hn::Set(f_bits, 2)));
    auto axis = [&](const F* of, int of_first, int of_second, int of_third) {  // where z is the first axis, the second, or the third
      return hn::IfThenElse(first, of[of_first], hn::IfThenElse(second, of[of_second], of[of_third]));
    };
    const F z = axis(rounded, 0, 1, 2);
    const auto backwards = hn::Lt(z, hn::Zero(f));
    auto swapped = [&](const F* of, F& x, F& y) {
      const F a = axis(of, 1, 2, 0), b = axis(of, 2, 0, 1);
      x = hn::IfThenElse(backwards, b, a), y = hn::IfThenElse(backwards, a, b);
    };
    F x, y;
    swapped(rounded, x, y);
    const V along = hn::PromoteTo(d, z);
    hn::Store(demoted_to_grid(hn::Div(hn::PromoteTo(d, x), along)), f, out.shear_x + begin);
    hn::Store(demoted_to_grid(hn::Div(hn::PromoteTo(d, y), along)), f, out.shear_y + begin);
    swapped(rounded_start, x, y);
    hn::Store(x, f, out.swapped_origin[0] + begin);
    hn::Store(y, f, out.swapped_origin[1] + begin);
    hn::Store(axis(rounded_start, 0, 1, 2), f, out.swapped_origin[2] + begin);
    const auto of = hn::Or(z_axis, hn::ShiftLeft<2>(hn::ShiftRight<31>(hn::BitCast(f_bits, z))));
    const hn::FixedTag<uint32_t, 8> table;
    auto store_axes = [&](auto numbers) {
      auto axes_of = [&](auto eight) { return hn::TableLookupLanes(hn::Load(table, kAxes), hn::IndicesFromVec(table, eight)); };
      auto* to = reinterpret_cast<uint32_t*>(out.axes + begin);
      if constexpr (kDoubles == 8) hn::Store(axes_of(numbers), f_bits, to);
      else hn::Store(hn::LowerHalf(axes_of(hn::ZeroExtendVector(table, numbers))), f_bits, to);
    };
    store_axes(of);

    const V t_min = columns[6], t_max = columns[7];
    const V s_scale = hn::Mul(hn::Set(d, frame.per_metre), hn::BitCast(d, exponent));  // 1 / t_scale
    const auto slack = hn::DemoteTo(f, hn::Mul(hn::Abs(t_start), hn::Set(d, 0x1p-50)));
    const auto below = hn::DemoteTo(f, hn::Sub(hn::Mul(t_min, s_scale), t_start));
    const auto above = hn::DemoteTo(f, hn::Sub(hn::Mul(t_max, s_scale), t_start));
    const auto relative = hn::Set(f, 0x1p-22f);
    hn::Store(hn::Sub(hn::Sub(below, hn::Mul(hn::Abs(below), relative)), slack), f, out.s_min + begin);
    hn::Store(hn::Add(hn::Add(above, hn::Mul(hn::Abs(above), relative)), slack), f, out.s_max + begin);
    hn::Store(t_start, d, out.t_start + begin);
    hn::Store(t_scale, d, out.t_scale + begin);
    hn::Store(s_scale, d, out.s_scale + begin);
    hn::Store(t_min, d, out.t_min + begin);
    hn::Store(t_max, d, out.t_max + begin);
    out.inside |= uint64_t(bits(d, inside)) << begin;
  }
  out.inside &= ~uint64_t(0) >> (64 - count);
}

}  // namespace tilecast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
