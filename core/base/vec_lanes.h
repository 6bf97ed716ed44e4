// Eight vectors at once; each lane as GLM does one, operation by operation.
#pragma once

#include "base/affine.h"
#include "base/lanes64.h"
#include "base/vec.h"

namespace tilecast {

struct Vec3Lanes {
  Double8 x, y, z;

  Vec3Lanes() = default;
  Vec3Lanes(const Double8& a, const Double8& b, const Double8& c) : x(a), y(b), z(c) {}
  explicit Vec3Lanes(const Vec3& v) : x(v.x), y(v.y), z(v.z) {}
  Vec3 operator[](int lane) const { return {x[lane], y[lane], z[lane]}; }
  void set(int lane, const Vec3& v) { x.set(lane, v.x), y.set(lane, v.y), z.set(lane, v.z); }

  friend Vec3Lanes operator+(const Vec3Lanes& a, const Vec3Lanes& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vec3Lanes operator-(const Vec3Lanes& a, const Vec3Lanes& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vec3Lanes operator-(const Vec3Lanes& a) { return {-a.x, -a.y, -a.z}; }
  friend Vec3Lanes operator*(const Vec3Lanes& a, const Vec3Lanes& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
  friend Vec3Lanes operator*(const Vec3Lanes& a, const Double8& b) { return {a.x * b, a.y * b, a.z * b}; }
  friend Vec3Lanes operator*(const Double8& a, const Vec3Lanes& b) { return {a * b.x, a * b.y, a * b.z}; }
  friend Vec3Lanes operator/(const Vec3Lanes& a, const Double8& b) { return {a.x / b, a.y / b, a.z / b}; }
};

inline Double8 dot(const Vec3Lanes& a, const Vec3Lanes& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3Lanes normalize(const Vec3Lanes& v) { return v * (Double8(1.0) / sqrt(dot(v, v))); }
inline Double8 max_abs(const Vec3Lanes& v) { return max(max(abs(v.x), abs(v.y)), abs(v.z)); }
inline Double8 max_component(const Vec3Lanes& v) { return max(max(v.x, v.y), v.z); }
inline Vec3Lanes choose(const Mask8d& m, const Vec3Lanes& a, const Vec3Lanes& b) {
  return {choose(m, a.x, b.x), choose(m, a.y, b.y), choose(m, a.z, b.z)};
}

inline Vec3Lanes multiply_add(const glm::dmat3& m, const Vec3Lanes& v, const Vec3& b) {
  auto row = [&](int i) { return fma(m[0][i], v.x, fma(m[1][i], v.y, fma(m[2][i], v.z, b[i]))); };
  return {row(0), row(1), row(2)};
}
// The row vector times the matrix.
inline Vec3Lanes operator*(const Vec3Lanes& v, const glm::dmat3& m) {
  auto column = [&](int i) { return Double8(m[i][0]) * v.x + Double8(m[i][1]) * v.y + Double8(m[i][2]) * v.z; };
  return {column(0), column(1), column(2)};
}

}  // namespace tilecast
