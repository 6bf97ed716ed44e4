// Signs that are exact in floating point.
//
// Kahan's difference of products with fused multiply-add has a relative error below 1.5 ulp, so its sign is that of
// the exact determinant as long as nothing underflows (Jeannerod, Louvet and Muller, "Further analysis of Kahan's
// algorithm for the accurate computation of 2 x 2 determinants", Math. Comp. 82, 2013). Callers keep their values on
// a grid coarse enough for that: see base/frame.h.
#pragma once

#include <cmath>

namespace tilecast {

// a * b - c * d
template <class T>
inline T difference_of_products(T a, T b, T c, T d) {
  T p = c * d;
  T e = std::fma(-c, d, p);
  T s = std::fma(a, b, -p);
  return s + e;
}

// On which side of the directed line p -> q the origin lies, in the plane: the sign of px * qy - py * qx. Where that
// is zero, the origin is shifted by (e, e^2) with e infinitesimal; 0 is left only where p equals q, an edge of length
// zero, which never separates. Swapping p and q flips the sign, so two triangles never disagree on a shared edge.
inline int edge_sign(float px, float py, float qx, float qy) {
  float value = difference_of_products(px, qy, py, qx);
  if (value != 0.0f) return value > 0.0f ? 1 : -1;
  if (qy != py) return qy < py ? 1 : -1;
  if (qx != px) return qx > px ? 1 : -1;
  return 0;
}

}  // namespace tilecast
