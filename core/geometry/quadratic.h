// The zeros of a t^2 + 2 b t + c, each to 4 u of itself.
//
// The coefficients come with twice the precision, which leaves the discriminant its digits where a line starts far off
// or grazes; the roots are q / a and c / q, q = -(b +- root), which do not cancel and stay right as a goes to zero
// (Haines, Gunther and Akenine-Moller, "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems, 2019,
// chapter 7).
#pragma once

#include <algorithm>

#include "base/twofold.h"
#include "base/vec.h"

namespace tilecast {

struct QuadraticRoots {
  double low, high;  // infinite where a is zero
  double discriminant, root;  // b^2 - a c, and its square root: |a t + b| at both

  // How far a zero moves when the function's value there is off by at most `perturbation`: to first order by half of
  // perturbation / root, and where the two zeros may meet, by no more than their common distance from the vertex.
  double error(double a, double perturbation) const {
    double shift = std::fabs(a) * perturbation;
    return discriminant > shift ? perturbation / root : std::sqrt(perturbation / std::fabs(a));
  }
};

// The discriminant, its root and q; false where there are no zeros, or only a double one, or where anything is not
// finite.
inline bool discriminate(const Twofold& a, const Twofold& b, const Twofold& c, QuadraticRoots& out, double& q) {
  // Fused, then the low parts: the rounding of one product is made good by the other's remainder.
  double product = a.hi * c.hi, remainder = std::fma(a.hi, c.hi, -product);
  double low = 2.0 * b.hi * b.lo - std::fma(a.hi, c.lo, a.lo * c.hi);
  out.discriminant = std::fma(b.hi, b.hi, -product) + (low - remainder);
  if (!(out.discriminant > 0.0)) return false;
  out.root = std::sqrt(out.discriminant);
  q = -(b.hi + std::copysign(out.root, b.hi) + b.lo);
  return true;
}

inline bool solve(const Twofold& a, const Twofold& b, const Twofold& c, QuadraticRoots& out) {
  double q;
  if (!discriminate(a, b, c, out, q)) return false;
  double first = q / (a.value() + 0.0);  // a zero is positive
  double second = c.value() / q;
  out.low = std::min(first, second);
  out.high = std::max(first, second);
  return true;
}

// The higher or the lower zero alone, the same digits; a > 0, and the two must lie well apart.
inline bool solve_one(const Twofold& a, const Twofold& b, const Twofold& c, bool higher, double& zero) {
  QuadraticRoots roots;
  double q;
  if (!discriminate(a, b, c, roots, q)) return false;
  zero = (q > 0.0) == higher ? q / a.value() : c.value() / q;
  return true;
}

}  // namespace tilecast
