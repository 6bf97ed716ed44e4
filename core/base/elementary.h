// Elementary functions with the same bits on every machine: libm picks its code by the processor, these do not.
// Accurate to about 1e-15.
#pragma once

#include "base/vec.h"

namespace tilecast {

// sin and cos of 2 pi u for u in [0, 1].
inline void sincos_2pi(double u, double& sine, double& cosine) {
  int quadrant = static_cast<int>(4.0 * u + 0.5);
  double r = (u - 0.25 * quadrant) * (2.0 * kPi);  // |r| <= pi / 4
  double r2 = r * r;
  double s = -1.0 / 1307674368000.0;  // Taylor, Horner with fused multiply-add
  s = std::fma(s, r2, 1.0 / 6227020800.0);
  s = std::fma(s, r2, -1.0 / 39916800.0);
  s = std::fma(s, r2, 1.0 / 362880.0);
  s = std::fma(s, r2, -1.0 / 5040.0);
  s = std::fma(s, r2, 1.0 / 120.0);
  s = std::fma(s, r2, -1.0 / 6.0);
  s = std::fma(s * r2, r, r);
  double c = 1.0 / 20922789888000.0;
  c = std::fma(c, r2, -1.0 / 87178291200.0);
  c = std::fma(c, r2, 1.0 / 479001600.0);
  c = std::fma(c, r2, -1.0 / 3628800.0);
  c = std::fma(c, r2, 1.0 / 40320.0);
  c = std::fma(c, r2, -1.0 / 720.0);
  c = std::fma(c, r2, 1.0 / 24.0);
  c = std::fma(c, r2, -0.5);
  c = std::fma(c, r2, 1.0);
  switch (quadrant & 3) {
    case 0: sine = s, cosine = c; break;
    case 1: sine = c, cosine = -s; break;
    case 2: sine = -s, cosine = -c; break;
    default: sine = -c, cosine = s; break;
  }
}

// e^x for x <= 0.
inline double exp_negative(double x) {
  if (!(x > -708.0)) return 0.0;  // e^-708 is about the least normal number
  double k = std::nearbyint(x * 1.4426950408889634);
  double r = std::fma(-k, 1.9082149292705877e-10, std::fma(-k, 0.6931471803691238, x));  // ln 2 in two parts
  double e = 1.0;
  for (int n = 14; n >= 1; --n) e = std::fma(e, r / n, 1.0);
  return std::ldexp(e, static_cast<int>(k));
}

}  // namespace tilecast
