// Eight doubles at once, in two vectors of base/double_lanes.h: beside base/lanes.h, with whose lanes they go.
#pragma once

#include "base/double_lanes.h"
#include "base/lanes.h"

namespace tilecast {

// A lane: all bits or none.
struct Mask8d {
  Mask4 half[2];

  friend Mask8d operator&(const Mask8d& a, const Mask8d& b) { return {{a.half[0] & b.half[0], a.half[1] & b.half[1]}}; }
  friend Mask8d operator|(const Mask8d& a, const Mask8d& b) { return {{a.half[0] | b.half[0], a.half[1] | b.half[1]}}; }
  friend Mask8d operator~(const Mask8d& a) { return {{~a.half[0], ~a.half[1]}}; }
  friend Mask8d operator==(const Mask8d& a, const Mask8d& b) { return {{a.half[0] == b.half[0], a.half[1] == b.half[1]}}; }
};

struct Double8 {
  Double4 half[2];

  Double8() = default;
  Double8(double x) : half{Double4{} + x, Double4{} + x} {}
  Double8(Double4 low, Double4 high) : half{low, high} {}
  double operator[](int lane) const { return half[lane >> 2][lane & 3]; }
  void set(int lane, double x) { half[lane >> 2][lane & 3] = x; }

  friend Double8 operator+(const Double8& a, const Double8& b) { return {a.half[0] + b.half[0], a.half[1] + b.half[1]}; }
  friend Double8 operator-(const Double8& a, const Double8& b) { return {a.half[0] - b.half[0], a.half[1] - b.half[1]}; }
  friend Double8 operator*(const Double8& a, const Double8& b) { return {a.half[0] * b.half[0], a.half[1] * b.half[1]}; }
  friend Double8 operator/(const Double8& a, const Double8& b) { return {a.half[0] / b.half[0], a.half[1] / b.half[1]}; }
  friend Double8 operator-(const Double8& a) { return {-a.half[0], -a.half[1]}; }
  friend Mask8d operator<(const Double8& a, const Double8& b) { return {{a.half[0] < b.half[0], a.half[1] < b.half[1]}}; }
  friend Mask8d operator>(const Double8& a, const Double8& b) { return {{a.half[0] > b.half[0], a.half[1] > b.half[1]}}; }
  friend Mask8d operator<=(const Double8& a, const Double8& b) { return {{a.half[0] <= b.half[0], a.half[1] <= b.half[1]}}; }
  friend Mask8d operator>=(const Double8& a, const Double8& b) { return {{a.half[0] >= b.half[0], a.half[1] >= b.half[1]}}; }
  friend Mask8d operator==(const Double8& a, const Double8& b) { return {{a.half[0] == b.half[0], a.half[1] == b.half[1]}}; }
};

inline Double8 choose(const Mask8d& m, const Double8& a, const Double8& b) {
  return {m.half[0] ? a.half[0] : b.half[0], m.half[1] ? a.half[1] : b.half[1]};
}
inline Double8 max(const Double8& a, const Double8& b) { return choose(a > b, a, b); }

inline Double8 abs(const Double8& x) { return {abs(x.half[0]), abs(x.half[1])}; }
inline Double8 copysign(const Double8& x, const Double8& sign) {
  return {copysign(x.half[0], sign.half[0]), copysign(x.half[1], sign.half[1])};
}
inline Double8 power_below(const Double8& x) { return {power_below(x.half[0]), power_below(x.half[1])}; }
inline Double8 power_below_reciprocal(const Double8& x) {
  return {power_below_reciprocal(x.half[0]), power_below_reciprocal(x.half[1])};
}

inline Double8 sqrt(const Double8& x) { return {sqrt(x.half[0]), sqrt(x.half[1])}; }
inline Double8 fma(const Double8& a, const Double8& b, const Double8& c) {
  return {fma(a.half[0], b.half[0], c.half[0]), fma(a.half[1], b.half[1], c.half[1])};
}
inline uint32_t bits(const Mask8d& m) { return bits(m.half[0]) | bits(m.half[1]) << kDoubles; }
inline Float8 to_float(const Double8& x) {
#ifdef __AVX2__
  return (Float8)_mm256_set_m128(_mm256_cvtpd_ps((__m256d)x.half[1]), _mm256_cvtpd_ps((__m256d)x.half[0]));
#else
  Float8 out;
  for (int i = 0; i < kLanes; ++i) out[i] = static_cast<float>(x[i]);
  return out;
#endif
}

// The lanes whose bits are set.
inline Mask8 lanes_of(uint32_t bits) {
  constexpr Mask8 kBits{1, 2, 4, 8, 16, 32, 64, 128};
  return ((Mask8{} + static_cast<int32_t>(bits)) & kBits) != 0;
}

}  // namespace tilecast
