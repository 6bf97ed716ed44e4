// Affine maps p' = A p + b in double, and their inverses.
#pragma once

#include "base/box.h"
#include "base/error.h"
#include "base/ray.h"

namespace tilecast {

// m v + b with one rounding for each of the products; one coordinate of it.
inline double multiply_add(const glm::dmat3& m, const Vec3& v, double b, int i) {
  return std::fma(m[0][i], v.x, std::fma(m[1][i], v.y, std::fma(m[2][i], v.z, b)));
}
inline Vec3 multiply_add(const glm::dmat3& m, const Vec3& v, const Vec3& b) {
  return {multiply_add(m, v, b.x, 0), multiply_add(m, v, b.y, 1), multiply_add(m, v, b.z, 2)};
}

// An upper bound on how much a matrix stretches a length (Frobenius norm).
inline double stretch(const glm::dmat3& m) {
  return std::sqrt(glm::dot(m[0], m[0]) + glm::dot(m[1], m[1]) + glm::dot(m[2], m[2]));
}

// Around the images of a box's corners. Empty and unbounded boxes stay as they are.
template <class Map>
Box map_box(const Map& map, const Box& b) {
  Box out;
  if (b.empty() || b.unbounded()) return b;
  for (int i = 0; i < 8; ++i) out.extend(map.point(b.corner(i)));
  return out;
}

struct Affine {
  glm::dmat3 linear{1.0};  // columns
  Vec3 offset{0.0};

  Vec3 point(const Vec3& p) const { return multiply_add(linear, p, offset); }
  Vec3 vector(const Vec3& v) const { return multiply_add(linear, v, Vec3(0.0)); }
  Ray ray(const Ray& r) const { return {point(r.origin), vector(r.direction), r.t_min, r.t_max}; }

  Box box(const Box& b) const { return map_box(*this, b); }
  double stretch() const { return tilecast::stretch(linear); }

  friend Affine operator*(const Affine& a, const Affine& b) {
    return {{a.vector(b.linear[0]), a.vector(b.linear[1]), a.vector(b.linear[2])}, a.point(b.offset)};
  }
};

// The inverse map, p = A^-1 (p' - b). The difference is taken first: near a place far from the world's origin it is
// exact, where A^-1 p' - A^-1 b would cancel.
struct InverseAffine {
  glm::dmat3 linear{1.0};
  Vec3 origin{0.0};

  Vec3 point(const Vec3& p) const { return vector(p - origin); }
  Vec3 vector(const Vec3& v) const { return multiply_add(linear, v, Vec3(0.0)); }
  Box box(const Box& b) const { return map_box(*this, b); }
  double stretch() const { return tilecast::stretch(linear); }
  Ray ray(const Ray& r) const { return {point(r.origin), vector(r.direction), r.t_min, r.t_max}; }
};

// Refuses maps that are singular to working precision, whatever their scale: throws Error.
InverseAffine inverse(const Affine& m);

}  // namespace tilecast
