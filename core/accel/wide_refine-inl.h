// Four triangles and rays that may cross, in double: lane by lane what refine (geometry/triangle.h) does.
#if defined(TILECAST_WIDE_REFINE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TILECAST_WIDE_REFINE_INL_H
#undef TILECAST_WIDE_REFINE_INL_H
#else
#define TILECAST_WIDE_REFINE_INL_H
#endif

#include "accel/wide_kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tilecast::HWY_NAMESPACE {

// A triangle that a ray may cross.
struct Candidate {
  const TriangleBlock* block;
  uint8_t lane, ray;
  bool tie, from_front;
};

struct Refined {
  static constexpr int kSize = 4;

  alignas(32) double t[kSize], u[kSize], v[kSize];
  uint32_t in_range;  // bit i: t_min < t[i] <= t_max, and the rest stands too
  uint32_t rare;      // bit i: to be done alone
};

HWY_INLINE void refine(const Candidate candidates[Refined::kSize], const FrameRays& rays, Refined& out) {
  const hn::FixedTag<double, 4> d;
  const hn::FixedTag<float, 4> f;
  using V = hn::Vec<decltype(d)>;
  const Candidate &c0 = candidates[0], &c1 = candidates[1], &c2 = candidates[2], &c3 = candidates[3];
  auto of_rays = [&](const double* values) {
    alignas(32) const double each[4] = {values[c0.ray], values[c1.ray], values[c2.ray], values[c3.ray]};
    return hn::Load(d, each);
  };
  const uint8_t* const axes[4] = {rays.axes[c0.ray], rays.axes[c1.ray], rays.axes[c2.ray], rays.axes[c3.ray]};
  V vertices[3][3], origin[3], direction[3];
  for (int i = 0; i < 3; ++i) {
    auto along_axis = [&](const double (&values)[3][FrameRays::kSize]) {
      alignas(32) const double each[4] = {values[axes[0][i]][c0.ray], values[axes[1][i]][c1.ray], values[axes[2][i]][c2.ray], values[axes[3][i]][c3.ray]};
      return hn::Load(d, each);
    };
    origin[i] = along_axis(rays.origin64), direction[i] = along_axis(rays.direction64);
    const float* plane[4];
    for (int k = 0; k < 4; ++k) plane[k] = candidates[k].block->vertices[0][axes[k][i]] + candidates[k].lane;
    constexpr int kVertex = 3 * WideNode::kWidth;  // from a vertex to the next
    for (int v = 0; v < 3; ++v) {
      alignas(16) const float each[4] = {plane[0][v * kVertex], plane[1][v * kVertex], plane[2][v * kVertex], plane[3][v * kVertex]};
      vertices[v][i] = hn::PromoteTo(d, hn::Load(f, each));
    }
  }
  const V shear_x = hn::Div(direction[0], direction[2]), shear_y = hn::Div(direction[1], direction[2]);
  V x[3], y[3], z[3];
  for (int i = 0; i < 3; ++i) {
    z[i] = hn::Sub(vertices[i][2], origin[2]);
    x[i] = hn::NegMulAdd(shear_x, z[i], hn::Sub(vertices[i][0], origin[0]));
    y[i] = hn::NegMulAdd(shear_y, z[i], hn::Sub(vertices[i][1], origin[1]));
  }
  V w[3];
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const V product = hn::Mul(y[j], x[k]);
    w[i] = hn::Add(hn::MulSub(x[j], y[k], product), hn::NegMulAdd(y[j], x[k], product));
  }
  const V zero = hn::Zero(d), sum = hn::Add(hn::Add(w[0], w[1]), w[2]);
  const auto within = hn::Or(hn::Ge(hn::Min(hn::Min(w[0], w[1]), w[2]), zero), hn::Le(hn::Max(hn::Max(w[0], w[1]), w[2]), zero));
  const auto usual = hn::And(within, hn::Ne(sum, zero));
  const V weighted = hn::Add(hn::Add(hn::Mul(w[0], z[0]), hn::Mul(w[1], z[1])), hn::Mul(w[2], z[2]));
  const V s = hn::Div(hn::Div(weighted, sum), direction[2]);
  const V t = hn::Mul(hn::Add(of_rays(rays.t_start), s), of_rays(rays.t_scale));
  const auto in_range = hn::And(hn::Gt(t, of_rays(rays.t_min)), hn::Le(t, of_rays(rays.t_max)));
  const uint32_t ties = c0.tie | c1.tie << 1 | c2.tie << 2 | c3.tie << 3;
  const uint32_t usual_bits = bits(d, usual);
  out.rare = (~usual_bits & 15) | ties;
  out.in_range = bits(d, in_range) & ~out.rare;
  if (out.in_range == 0) return;
  hn::Store(t, d, out.t);
  hn::Store(hn::Div(w[1], sum), d, out.u);
  hn::Store(hn::Div(w[2], sum), d, out.v);
}

}  // namespace tilecast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
