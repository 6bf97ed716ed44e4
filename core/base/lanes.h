// Eight floats at once, in the compiler's vectors: plain operators, and what those lack.
#pragma once

#include <cmath>
#include <cstdint>
#ifdef __AVX2__
#include <immintrin.h>
#endif

namespace tilecast {

inline constexpr int kLanes = 8;
using Float8 = float __attribute__((vector_size(32)));
using Mask8 = int32_t __attribute__((vector_size(32)));  // a lane: all bits or none

inline constexpr Mask8 kLaneNumbers{0, 1, 2, 3, 4, 5, 6, 7};

inline Float8 all(float x) { return Float8{} + x; }
inline Float8 min(Float8 a, Float8 b) { return a < b ? a : b; }
inline Float8 max(Float8 a, Float8 b) { return a > b ? a : b; }

inline float least(Float8 x) {
  x = min(x, __builtin_shufflevector(x, x, 4, 5, 6, 7, 0, 1, 2, 3));
  x = min(x, __builtin_shufflevector(x, x, 2, 3, 0, 1, 6, 7, 4, 5));
  return x[0] < x[1] ? x[0] : x[1];
}
inline float greatest(Float8 x) { return -least(-x); }

#ifdef __AVX2__
inline Float8 sqrt(Float8 x) { return (Float8)_mm256_sqrt_ps((__m256)x); }
inline Float8 fma(Float8 a, Float8 b, Float8 c) { return (Float8)_mm256_fmadd_ps((__m256)a, (__m256)b, (__m256)c); }
// One bit a lane.
inline uint32_t bits(Mask8 m) { return static_cast<uint32_t>(_mm256_movemask_ps((__m256)m)); }
#else
inline Float8 sqrt(Float8 x) {
  for (int i = 0; i < kLanes; ++i) x[i] = std::sqrt(x[i]);
  return x;
}
inline Float8 fma(Float8 a, Float8 b, Float8 c) {
  for (int i = 0; i < kLanes; ++i) c[i] = std::fma(a[i], b[i], c[i]);
  return c;
}
inline uint32_t bits(Mask8 m) {
  uint32_t out = 0;
  for (int i = 0; i < kLanes; ++i) out |= static_cast<uint32_t>(m[i] & 1) << i;
  return out;
}
#endif

}  // namespace tilecast
