// Affine maps p' = A p + b in double, and their inverses.
#pragma once

#include "base/box.h"
#include "base/error.h"
#include "base/ray.h"

namespace tilecast {

struct Affine {
  glm::dmat3 linear{1.0};  // columns
  Vec3 offset{0.0};

  Vec3 point(const Vec3& p) const { return linear * p + offset; }
  Vec3 vector(const Vec3& v) const { return linear * v; }
  Ray ray(const Ray& r) const { return {point(r.origin), vector(r.direction), r.t_min, r.t_max}; }

  Box box(const Box& b) const {
    Box out;
    if (b.empty()) return out;
    for (int i = 0; i < 8; ++i) out.extend(point(b.corner(i)));
    return out;
  }

  // An upper bound on how much the map stretches a length (Frobenius norm).
  double stretch() const {
    return std::sqrt(glm::dot(linear[0], linear[0]) + glm::dot(linear[1], linear[1]) + glm::dot(linear[2], linear[2]));
  }

  friend Affine operator*(const Affine& a, const Affine& b) { return {a.linear * b.linear, a.point(b.offset)}; }
};

// Refuses maps that are singular to working precision, whatever their scale: the volume spanned by the columns is
// compared with the product of their lengths. Columns are brought to unit length first, so nothing overflows.
inline Affine inverse(const Affine& m) {
  if (!is_finite(m.linear[0]) || !is_finite(m.linear[1]) || !is_finite(m.linear[2]) || !is_finite(m.offset))
    throw Error("transform has a value that is not finite");
  glm::dmat3 unit;
  Vec3 length;
  for (int i = 0; i < 3; ++i) {
    double largest = max_abs(m.linear[i]);
    if (largest == 0.0) throw Error("transform is singular: it flattens space");
    Vec3 scaled = m.linear[i] / largest;
    double norm = glm::length(scaled);
    unit[i] = scaled / norm;
    length[i] = norm * largest;
  }
  double volume = glm::dot(unit[0], glm::cross(unit[1], unit[2]));
  if (!(std::fabs(volume) > 8 * kUnitRoundoff)) throw Error("transform is singular: it flattens space");
  Affine out;
  Vec3 rows[3] = {glm::cross(unit[1], unit[2]), glm::cross(unit[2], unit[0]), glm::cross(unit[0], unit[1])};
  for (int i = 0; i < 3; ++i) {
    Vec3 row = rows[i] / volume / length[i];
    if (!is_finite(row)) throw Error("transform is singular: its inverse is beyond the range of double");
    for (int j = 0; j < 3; ++j) out.linear[j][i] = row[j];
  }
  out.offset = -(out.linear * m.offset);
  return out;
}

}  // namespace tilecast
