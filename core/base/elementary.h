// Elementary functions with the same bits on every machine: libm picks its code by the processor, these do not.
// Accurate to about 1e-15.
#pragma once

#include "base/vec.h"

namespace tilecast {

// A polynomial by Horner's rule with fused multiply-add; the coefficient of the highest power first.
template <class... Lower>
double polynomial(double x, double highest, Lower... lower) {
  ((highest = std::fma(highest, x, lower)), ...);
  return highest;
}

// sin and cos of 2 pi u for u in [0, 1].
inline void sincos_2pi(double u, double& sine, double& cosine) {
  int quadrant = static_cast<int>(4.0 * u + 0.5);
  double r = (u - 0.25 * quadrant) * (2.0 * kPi);  // |r| <= pi / 4
  double r2 = r * r;
  // Taylor.
  double s = polynomial(r2, -1.0 / 1307674368000.0, 1.0 / 6227020800.0, -1.0 / 39916800.0, 1.0 / 362880.0, -1.0 / 5040.0,
                        1.0 / 120.0, -1.0 / 6.0);
  s = std::fma(s * r2, r, r);
  const double c = polynomial(r2, 1.0 / 20922789888000.0, -1.0 / 87178291200.0, 1.0 / 479001600.0, -1.0 / 3628800.0,
                              1.0 / 40320.0, -1.0 / 720.0, 1.0 / 24.0, -0.5, 1.0);
  switch (quadrant & 3) {
    case 0: sine = s, cosine = c; break;
    case 1: sine = c, cosine = -s; break;
    case 2: sine = -s, cosine = -c; break;
    default: sine = -c, cosine = s; break;
  }
}

// The cosine and the tangent of 2 pi u for u in [0, 1].
inline double cos_2pi(double u) {
  double sine, cosine;
  sincos_2pi(u, sine, cosine);
  return cosine;
}
inline double tan_2pi(double u) {
  double sine, cosine;
  sincos_2pi(u, sine, cosine);
  return sine / cosine;
}

// The angle of (x, y) with the x axis over 2 pi, in [-0.5, 0.5]; 0 at the origin.
inline double atan2_turns(double y, double x) {
  static constexpr double kAngles[] = {0.0, 0.12435499454676144, 0.24497866312686414, 0.35877067027057225,
                                       0.4636476090008061, 0.5585993153435624, 0.6435011087932844,
                                       0.7188299996216245, 0.7853981633974483};  // arctangents of k / 8
  const double ax = std::fabs(x), ay = std::fabs(y);
  const bool steep = ay > ax;
  const double low = steep ? ax : ay, high = steep ? ay : ax;
  if (!(high > 0.0)) return 0.0;
  // atan(t) = atan(c) + atan((t - c) / (1 + t c)), with c within 1/16 of t.
  const double t = low / high;
  const int k = static_cast<int>(8.0 * t + 0.5);
  const double c = 0.125 * k, z = (t - c) / std::fma(t, c, 1.0), z2 = z * z;
  const double s = polynomial(z2, 1.0 / 13.0, -1.0 / 11.0, 1.0 / 9.0, -1.0 / 7.0, 1.0 / 5.0, -1.0 / 3.0);
  const double angle = (kAngles[k] + std::fma(s * z2, z, z)) * (0.5 * kInvPi);
  const double first = steep ? 0.25 - angle : angle;  // in the first quadrant
  return std::copysign(x < 0.0 ? 0.5 - first : first, y);
}

// The angle between two directions of any length, over 2 pi: in [0, 0.5].
inline double turns_between(const Vec3& a, const Vec3& b) {
  return atan2_turns(glm::length(glm::cross(a, b)), glm::dot(a, b));
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

// The natural logarithm of a normal number > 0.
inline double log_positive(double x) {
  int exponent;
  double m = std::frexp(x, &exponent);  // [1/2, 1)
  if (m < 0.7071067811865476) m *= 2.0, --exponent;
  double s = (m - 1.0) / (m + 1.0), s2 = s * s;  // ln m = 2 artanh s, |s| < 0.172
  double sum = 0.0;
  for (int n = 23; n >= 3; n -= 2) sum = std::fma(sum, s2, 1.0 / n);
  double tail = std::fma(exponent, 1.9082149292705877e-10, 2.0 * s * s2 * sum);
  return std::fma(exponent, 0.6931471803691238, tail + 2.0 * s);
}

// x^y for x in [0, 1], y >= 0; 0^0 is 1.
inline double power_of_unit(double x, double y) {
  if (y == 0.0) return 1.0;
  return x < 0x1p-1022 ? 0.0 : exp_negative(std::min(0.0, y * log_positive(x)));
}

// arccos for x in [0, 1]: the rational function of Sun's fdlibm.
inline double acos_unit(double x) {
  auto tail = [](double z) {  // (arcsin(sqrt z) / sqrt z - 1), z <= 1/4
    const double p = polynomial(z, 3.47933107596021167570e-05, 7.91534994289814532176e-04, -4.00555345006794114027e-02,
                                2.01212532134862925881e-01, -3.25565818622400915405e-01, 1.66666666666666657415e-01);
    const double q = polynomial(z, 7.70381505559019352791e-02, -6.88283971605453293030e-01, 2.02094576023350569471e+00,
                                -2.40339491173441421878e+00, 1.0);
    return z * p / q;
  };
  if (x < 0.5) return 0.5 * kPi - std::fma(x, tail(x * x), x);
  double z = 0.5 * (1.0 - x), s = std::sqrt(z);
  return 2.0 * std::fma(s, tail(z), s);
}

}  // namespace tilecast
