// Four doubles at once, in the compiler's vectors: plain operators, and what those lack. Each lane has the bits that plain
// code has: the same operations in the same order, fused where they say so.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#ifdef __AVX2__
#include <immintrin.h>
#endif

#include "base/elementary.h"

namespace tilecast {

inline constexpr int kDoubles = 4;
using Double4 = double __attribute__((vector_size(32)));
using Mask4 = int64_t __attribute__((vector_size(32)));  // a lane: all bits or none
using Uint4 = uint32_t __attribute__((vector_size(16)));

inline Double4 all(double x) { return Double4{x, x, x, x}; }
inline Mask4 all(bool x) { return Mask4{} - int64_t(x); }
inline Double4 load4(const double* p) {
  Double4 out;
  std::memcpy(&out, p, sizeof(out));
  return out;
}
inline Uint4 load4(const uint32_t* p) {
  Uint4 out;
  std::memcpy(&out, p, sizeof(out));
  return out;
}
inline void store4(double* p, Double4 x) { std::memcpy(p, &x, sizeof(x)); }

// Those of std::min and std::max: of equal ones the first.
inline Double4 min(Double4 a, Double4 b) { return b < a ? b : a; }
inline Double4 max(Double4 a, Double4 b) { return a < b ? b : a; }
inline Double4 abs(Double4 x) { return (Double4)((Mask4)x & INT64_MAX); }
inline Double4 copysign(Double4 x, Double4 sign) { return (Double4)(((Mask4)x & INT64_MAX) | ((Mask4)sign & INT64_MIN)); }
inline Double4 choose(Mask4 m, Double4 a, Double4 b) { return m ? a : b; }

// Those of base/frame.h.
inline Double4 power_below(Double4 x) { return (Double4)((Mask4)x & (int64_t(0x7ff) << 52)); }
inline Double4 power_below_reciprocal(Double4 x) {
  return (Double4)((int64_t(0x7fe) << 52) - ((Mask4)x & (int64_t(0x7ff) << 52)));
}

#ifdef __AVX2__
inline Double4 sqrt(Double4 x) { return (Double4)_mm256_sqrt_pd((__m256d)x); }
inline Double4 fma(Double4 a, Double4 b, Double4 c) { return (Double4)_mm256_fmadd_pd((__m256d)a, (__m256d)b, (__m256d)c); }
inline Double4 floor(Double4 x) { return (Double4)_mm256_floor_pd((__m256d)x); }
// One bit a lane.
inline uint32_t bits(Mask4 m) { return static_cast<uint32_t>(_mm256_movemask_pd((__m256d)m)); }
inline Mask4 widen(Uint4 x) { return (Mask4)_mm256_cvtepu32_epi64((__m128i)x); }
#else
inline Double4 sqrt(Double4 x) { return {std::sqrt(x[0]), std::sqrt(x[1]), std::sqrt(x[2]), std::sqrt(x[3])}; }
inline Double4 fma(Double4 a, Double4 b, Double4 c) {
  return {std::fma(a[0], b[0], c[0]), std::fma(a[1], b[1], c[1]), std::fma(a[2], b[2], c[2]), std::fma(a[3], b[3], c[3])};
}
inline Double4 floor(Double4 x) { return {std::floor(x[0]), std::floor(x[1]), std::floor(x[2]), std::floor(x[3])}; }
inline uint32_t bits(Mask4 m) { return (m[0] & 1) | (m[1] & 2) | (m[2] & 4) | (m[3] & 8); }
inline Mask4 widen(Uint4 x) { return {x[0], x[1], x[2], x[3]}; }
#endif

// Exact.
inline Double4 to_double(Uint4 x) {
  const Mask4 magic = Mask4{} + 0x4330000000000000;  // 2^52, whose last bits count ones
  return (Double4)(widen(x) | magic) - 0x1p52;
}

struct Vec3x4 {  // four vectors
  Double4 x, y, z;
};

inline Vec3x4 all(const Vec3& v) { return {all(v.x), all(v.y), all(v.z)}; }
inline Vec3x4 operator+(const Vec3x4& a, const Vec3x4& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3x4 operator-(const Vec3x4& v) { return {-v.x, -v.y, -v.z}; }
inline Vec3x4 operator-(const Vec3x4& a, const Vec3x4& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3x4 operator*(const Vec3x4& a, const Vec3x4& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
inline Vec3x4 operator*(const Vec3x4& a, Double4 b) { return {a.x * b, a.y * b, a.z * b}; }
inline Vec3x4 operator*(Double4 a, const Vec3x4& b) { return {a * b.x, a * b.y, a * b.z}; }
inline Vec3x4 operator/(const Vec3x4& a, Double4 b) { return {a.x / b, a.y / b, a.z / b}; }
inline Vec3x4 select(Mask4 m, const Vec3x4& a, const Vec3x4& b) { return {m ? a.x : b.x, m ? a.y : b.y, m ? a.z : b.z}; }

// As GLM's.
inline Double4 dot(const Vec3x4& a, const Vec3x4& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3x4 normalize(const Vec3x4& v) { return v * (1.0 / sqrt(dot(v, v))); }

inline Double4 max_abs(const Vec3x4& v) { return max(max(abs(v.x), abs(v.y)), abs(v.z)); }
inline Double4 max_component(const Vec3x4& v) { return max(max(v.x, v.y), v.z); }

template <class... Lower>
Double4 polynomial4(Double4 x, double highest, Lower... lower) {
  Double4 sum = all(highest);
  ((sum = fma(sum, x, all(lower))), ...);
  return sum;
}

// sincos_2pi of base/elementary.h.
inline void sincos_2pi(Double4 u, Double4& sine, Double4& cosine) {
  const Double4 quadrant = floor(4.0 * u + 0.5);  // 0 to 4
  const Double4 r = (u - 0.25 * quadrant) * (2.0 * kPi), r2 = r * r;
  Double4 s = polynomial4(r2, -1.0 / 1307674368000.0, 1.0 / 6227020800.0, -1.0 / 39916800.0, 1.0 / 362880.0, -1.0 / 5040.0,
                          1.0 / 120.0, -1.0 / 6.0);
  s = fma(s * r2, r, r);
  const Double4 c = polynomial4(r2, 1.0 / 20922789888000.0, -1.0 / 87178291200.0, 1.0 / 479001600.0, -1.0 / 3628800.0,
                                1.0 / 40320.0, -1.0 / 720.0, 1.0 / 24.0, -0.5, 1.0);
  const Mask4 odd = (quadrant == 1.0) | (quadrant == 3.0), half = (quadrant == 2.0) | (quadrant == 3.0);
  const Mask4 right = (quadrant == 1.0) | (quadrant == 2.0);  // where the cosine is negative
  const Double4 sine_of = odd ? c : s, cosine_of = odd ? s : c;
  sine = half ? -sine_of : sine_of;
  cosine = right ? -cosine_of : cosine_of;
}

// Four rows of four, [lane][column], turned: column by column.
inline void turn(const double* const rows[kDoubles], int column, Double4 out[kDoubles]) {
  const Double4 a = load4(rows[0] + column), b = load4(rows[1] + column);
  const Double4 c = load4(rows[2] + column), d = load4(rows[3] + column);
  const Double4 ab0 = __builtin_shufflevector(a, b, 0, 4, 2, 6), ab1 = __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Double4 cd0 = __builtin_shufflevector(c, d, 0, 4, 2, 6), cd1 = __builtin_shufflevector(c, d, 1, 5, 3, 7);
  out[0] = __builtin_shufflevector(ab0, cd0, 0, 1, 4, 5);
  out[1] = __builtin_shufflevector(ab1, cd1, 0, 1, 4, 5);
  out[2] = __builtin_shufflevector(ab0, cd0, 2, 3, 6, 7);
  out[3] = __builtin_shufflevector(ab1, cd1, 2, 3, 6, 7);
}

// Writes the lanes of a mask's bits one behind the other; the places up to the fourth hold anything afterwards.
struct Kept {
  alignas(32) int32_t halves[16][8];  // of doubles
  alignas(16) int32_t numbers[16][4];

  constexpr Kept() : halves{}, numbers{} {
    for (int mask = 0; mask < 16; ++mask) {
      int at = 0;
      for (int lane = 0; lane < 4; ++lane)
        if (mask >> lane & 1) {
          halves[mask][2 * at] = 2 * lane, halves[mask][2 * at + 1] = 2 * lane + 1;
          numbers[mask][at++] = lane;
        }
    }
  }
};
inline constexpr Kept kKept;

inline void keep(double* p, Double4 x, uint32_t mask) {
#ifdef __AVX2__
  const __m256i order = _mm256_load_si256((const __m256i*)kKept.halves[mask]);
  _mm256_storeu_ps((float*)p, _mm256_permutevar8x32_ps((__m256)x, order));
#else
  for (int lane = 0, at = 0; lane < kDoubles; ++lane)
    if (mask >> lane & 1) p[at++] = x[lane];
#endif
}
inline void keep(uint32_t* p, Uint4 x, uint32_t mask) {
#ifdef __AVX2__
  const __m128i order = _mm_load_si128((const __m128i*)kKept.numbers[mask]);
  _mm_storeu_ps((float*)p, _mm_permutevar_ps((__m128)x, order));
#else
  for (int lane = 0, at = 0; lane < kDoubles; ++lane)
    if (mask >> lane & 1) p[at++] = x[lane];
#endif
}

}  // namespace tilecast
