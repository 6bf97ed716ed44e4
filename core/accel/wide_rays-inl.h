// Rays brought into a frame at once: bit for bit what enter_frame (base/frame.h) does with each.
#if defined(TILECAST_WIDE_RAYS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TILECAST_WIDE_RAYS_INL_H
#undef TILECAST_WIDE_RAYS_INL_H
#else
#define TILECAST_WIDE_RAYS_INL_H
#endif

#include <hwy/highway.h>

#include "accel/wide_bvh.h"
#include "geometry/triangle.h"

HWY_BEFORE_NAMESPACE();
namespace tilecast::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// At most eight lanes' answers, as bits.
template <class D, class M>
HWY_INLINE uint32_t bits(D d, M mask) {
  uint8_t out[8];
  hn::StoreMaskBits(d, mask, out);
  return out[0];
}

struct alignas(32) FrameRays {
  static constexpr int kSize = 64;
  static constexpr int kPacket = 16;  // neighbours that may go together

  float origin[3][kSize], reciprocal[3][kSize];
  float scaled_origin[3][kSize];  // origin * reciprocal
  float shear_x[kSize], shear_y[kSize];
  float swapped_origin[3][kSize];    // origin in the order x, y, z
  uint32_t near_plane[3][kSize];     // where in WideNode::planes the first plane of each axis stands that the ray meets
  float s_min[kSize], s_max[kSize];  // s_max goes down with the hits
  // As in ShearedLine.
  double sheared_origin[3][kSize];
  double shear_x64[kSize], shear_y64[kSize], along[kSize];
  double t_start[kSize], t_scale[kSize];
  double t_min[kSize], t_max[kSize];
  uint32_t octant[kSize];                 // bit i: component i of the direction is negative
  uint8_t x[kSize], y[kSize], z[kSize];   // axes, as in FrameRay
  uint64_t inside;                        // bit i: line i may meet the frame's content

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
    swapped_origin[0][0] = from.origin[from.x], swapped_origin[1][0] = from.origin[from.y], swapped_origin[2][0] = from.origin[from.z];
    const ShearedLine exact = tilecast::sheared(from);
    for (int i = 0; i < 3; ++i) sheared_origin[i][0] = exact.origin[i];
    shear_x64[0] = exact.shear_x, shear_y64[0] = exact.shear_y, along[0] = exact.along;
    shear_x[0] = from.shear_x, shear_y[0] = from.shear_y;
    x[0] = static_cast<uint8_t>(from.x), y[0] = static_cast<uint8_t>(from.y), z[0] = static_cast<uint8_t>(from.z);
    t_start[0] = from.t_start, t_scale[0] = from.t_scale;
    t_min[0] = from_t_min, t_max[0] = from_t_max;
    s_min[0] = from.s_below(from_t_min), s_max[0] = from.s_above(from_t_max);
  }

  ShearedLine sheared(int i) const {
    return {{sheared_origin[0][i], sheared_origin[1][i], sheared_origin[2][i]}, shear_x64[i], shear_y64[i], along[i], t_start[i], t_scale[i]};
  }

  // What box tests look at.
  void copy_lane(int from, int to) {
    for (int axis = 0; axis < 3; ++axis) {
      origin[axis][to] = origin[axis][from];
      reciprocal[axis][to] = reciprocal[axis][from];
      scaled_origin[axis][to] = scaled_origin[axis][from];
    }
    s_min[to] = s_min[from], s_max[to] = s_max[from], octant[to] = octant[from], z[to] = z[from];
    shear_x[to] = shear_x[from], shear_y[to] = shear_y[from];
    for (auto& origins : swapped_origin) origins[to] = origins[from];
  }

  void lower_t_max(int i, double t) {
    t_max[i] = t;
    float s = static_cast<float>(t / t_scale[i] - t_start[i]);
    s_max[i] = s + std::fabs(s) * 0x1p-22f + static_cast<float>(std::fabs(t_start[i]) * 0x1p-50);
  }
};

// Four rays' numbers, each as a vector, in the order that they stand in a ray.
template <class V>
HWY_INLINE void load_columns(const Ray* const rays[4], V out[8]) {
  static_assert(sizeof(Ray) == 8 * sizeof(double));
  const hn::FixedTag<double, 4> d;
  for (int half = 0; half < 8; half += 4) {
    V row[4];
    for (int k = 0; k < 4; ++k) row[k] = hn::LoadU(d, reinterpret_cast<const double*>(rays[k]) + half);
    const V even01 = hn::InterleaveLower(d, row[0], row[1]), even23 = hn::InterleaveLower(d, row[2], row[3]);
    const V odd01 = hn::InterleaveUpper(d, row[0], row[1]), odd23 = hn::InterleaveUpper(d, row[2], row[3]);
    out[half] = hn::ConcatLowerLower(d, even23, even01), out[half + 1] = hn::ConcatLowerLower(d, odd23, odd01);
    out[half + 2] = hn::ConcatUpperUpper(d, even23, even01), out[half + 3] = hn::ConcatUpperUpper(d, odd23, odd01);
  }
}

// The axes x, y and z of a FrameRay, where z is the first one (1), the second (2) or the third (0), 4 more: backwards.
inline constexpr uint8_t kAxes[7][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {}, {1, 0, 2}, {2, 1, 0}, {0, 2, 1}};

// At most kSize rays. Lanes beyond `count` repeat the last ray and are not inside.
HWY_INLINE void enter_frame(const Frame& frame, const Ray* const* rays, int count, FrameRays& out) {
  const hn::FixedTag<double, 4> d;
  const hn::FixedTag<int64_t, 4> d_bits;
  const hn::FixedTag<float, 4> f;
  const hn::FixedTag<uint32_t, 4> f_bits;
  using V = hn::Vec<decltype(d)>;
  auto dot = [](const V* a, const V* b) { return hn::Add(hn::Add(hn::Mul(a[0], b[0]), hn::Mul(a[1], b[1])), hn::Mul(a[2], b[2])); };
  auto demoted_to_grid = [&](V v) {
    return hn::DemoteTo(f, hn::Mul(hn::Round(hn::Mul(v, hn::Set(d, 1.0 / kGrid))), hn::Set(d, kGrid)));
  };
  out.inside = 0;
  for (int begin = 0; begin < count; begin += 4) {
    const Ray* r[4];
    for (int k = 0; k < 4; ++k) r[k] = rays[std::min(begin + k, count - 1)];
    V columns[8];
    load_columns(r, columns);
    V origin[3], direction[3], start[3];
    for (int i = 0; i < 3; ++i) {
      origin[i] = hn::Mul(hn::Sub(columns[i], hn::Set(d, frame.centre[i])), hn::Set(d, 1.0 / frame.scale));
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

    V rounded[3], rounded_start[3];  // directions and starts
    auto octant = hn::Zero(f_bits);
    for (int i = 0; i < 3; ++i) {
      const auto o = demoted_to_grid(start[i]), dir = demoted_to_grid(direction[i]);
      const auto least = hn::Set(f, 0x1p-40f);
      const auto reciprocal = hn::Div(hn::Set(f, 1.0f), hn::IfThenElse(hn::Lt(hn::Abs(dir), least), hn::CopySign(least, dir), dir));
      rounded[i] = hn::PromoteTo(d, dir), rounded_start[i] = hn::PromoteTo(d, o);
      const auto negative = hn::ShiftRight<31>(hn::BitCast(f_bits, reciprocal));
      octant = hn::Or(octant, hn::ShiftLeftSame(negative, i));
      const auto near_plane = hn::Add(hn::Set(f_bits, 2 * WideNode::kWidth * i), hn::ShiftLeft<3>(negative));
      static_assert(WideNode::kWidth == 8);
      hn::Store(near_plane, f_bits, out.near_plane[i] + begin);
      hn::Store(o, f, out.origin[i] + begin);
      hn::Store(reciprocal, f, out.reciprocal[i] + begin);
      hn::Store(hn::Mul(o, reciprocal), f, out.scaled_origin[i] + begin);
    }
    hn::Store(octant, f_bits, out.octant + begin);

    const V size[3] = {hn::Abs(direction[0]), hn::Abs(direction[1]), hn::Abs(direction[2])};
    const auto z_is_x = hn::And(hn::Ge(size[0], size[1]), hn::Ge(size[0], size[2]));
    const auto z_is_y = hn::And(hn::Lt(size[0], size[1]), hn::Ge(size[1], size[2]));
    auto axis = [&](int of_x, int of_y, int of_z, const V* v) {
      return hn::IfThenElse(z_is_x, v[of_x], hn::IfThenElse(z_is_y, v[of_y], v[of_z]));
    };
    const auto backwards = hn::Lt(axis(0, 1, 2, rounded), hn::Zero(d));
    auto sheared = [&](const V* v, V& x, V& y, V& z) {
      const V first = axis(1, 2, 0, v), second = axis(2, 0, 1, v);
      x = hn::IfThenElse(backwards, second, first), y = hn::IfThenElse(backwards, first, second), z = axis(0, 1, 2, v);
    };
    V x, y, z;
    sheared(rounded, x, y, z);
    hn::Store(demoted_to_grid(hn::Div(x, z)), f, out.shear_x + begin);
    hn::Store(demoted_to_grid(hn::Div(y, z)), f, out.shear_y + begin);
    sheared(rounded_start, x, y, z);
    hn::Store(hn::DemoteTo(f, x), f, out.swapped_origin[0] + begin);
    hn::Store(hn::DemoteTo(f, y), f, out.swapped_origin[1] + begin);
    hn::Store(hn::DemoteTo(f, z), f, out.swapped_origin[2] + begin);
    sheared(direction, x, y, z);
    hn::Store(hn::Div(x, z), d, out.shear_x64 + begin);
    hn::Store(hn::Div(y, z), d, out.shear_y64 + begin);
    hn::Store(z, d, out.along + begin);
    sheared(start, x, y, z);
    hn::Store(x, d, out.sheared_origin[0] + begin);
    hn::Store(y, d, out.sheared_origin[1] + begin);
    hn::Store(z, d, out.sheared_origin[2] + begin);
    const uint32_t x_bits = bits(d, z_is_x), y_bits = bits(d, z_is_y), back_bits = bits(d, backwards);
    for (int k = 0; k < 4; ++k) {
      const uint32_t of = (x_bits >> k & 1) | (y_bits >> k & 1) << 1 | (back_bits >> k & 1) << 2;
      out.x[begin + k] = kAxes[of][0], out.y[begin + k] = kAxes[of][1], out.z[begin + k] = kAxes[of][2];
    }

    const V t_min = columns[6], t_max = columns[7];
    const V s_scale = hn::Div(hn::Set(d, 1.0), t_scale);
    const auto slack = hn::DemoteTo(f, hn::Mul(hn::Abs(t_start), hn::Set(d, 0x1p-50)));
    const auto below = hn::DemoteTo(f, hn::Sub(hn::Mul(t_min, s_scale), t_start));
    const auto above = hn::DemoteTo(f, hn::Sub(hn::Mul(t_max, s_scale), t_start));
    const auto relative = hn::Set(f, 0x1p-22f);
    hn::Store(hn::Sub(hn::Sub(below, hn::Mul(hn::Abs(below), relative)), slack), f, out.s_min + begin);
    hn::Store(hn::Add(hn::Add(above, hn::Mul(hn::Abs(above), relative)), slack), f, out.s_max + begin);
    hn::Store(t_start, d, out.t_start + begin);
    hn::Store(t_scale, d, out.t_scale + begin);
    hn::Store(t_min, d, out.t_min + begin);
    hn::Store(t_max, d, out.t_max + begin);
    out.inside |= uint64_t(bits(d, inside)) << begin;
  }
  out.inside &= ~uint64_t(0) >> (64 - count);
}

}  // namespace tilecast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
