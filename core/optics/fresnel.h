// Fresnel reflection and refraction at a smooth dielectric boundary.
//
// Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007, equation 22, rearranged so that
// nothing cancels: with g = eta cos(theta_t), g - c is (eta^2 - 1) / (g + c), and c (g -+ c) +- 1 is c g +- sin^2.
// Whether the reflection is total is decided once, here.
#pragma once

#include "base/twofold.h"
#include "base/vec.h"

namespace tilecast {

struct Fresnel {
  double reflectance;    // unpolarised; 1 where reflection is total
  double cos_transmitted;  // 0 where reflection is total
  bool total;
};

// cos_incident in [0, 1]; eta: index of refraction behind the boundary over that in front of it.
inline Fresnel fresnel_dielectric(double cos_incident, double eta) {
  double c = cos_incident;
  // g^2 = eta^2 + c^2 - 1, the squares with their rounding errors; the 1 is taken where it cancels exactly.
  Twofold eta2 = two_product(eta, eta), c2 = two_product(c, c);
  Twofold near = c2.hi >= 0.5 ? two_sum(eta2.hi, c2.hi - 1.0) : two_sum(eta2.hi - 1.0, c2.hi);
  Twofold rest = two_sum(eta2.lo, c2.lo), sum = two_sum(near.hi, rest.hi);
  double g2 = sum.hi + (sum.lo + (near.lo + rest.lo));
  if (g2 <= 0.0) return {1.0, 0.0, true};
  double g = std::sqrt(g2);
  double sin2 = (1.0 - c) * (1.0 + c);
  double a = ((eta2.hi - 1.0) + eta2.lo) / ((g + c) * (g + c));
  double b = (c * g - sin2) / (c * g + sin2);
  double reflectance = 0.5 * a * a * (1.0 + b * b);
  if (reflectance > 0.3) {  // what is transmitted, from the amplitudes of the two polarisations, is then more exact
    double s = g + c, p = eta * eta * c + g;
    reflectance = 1.0 - 2.0 * c * g * (1.0 / (s * s) + eta * eta / (p * p));
  }
  return {reflectance, g / eta, false};
}

// The refracted direction of one that arrives against the z axis: wo points away from the surface, wo.z > 0.
inline Vec3 refract(const Vec3& wo, double eta, double cos_transmitted) {
  return {-wo.x / eta, -wo.y / eta, -cos_transmitted};
}

inline Vec3 reflect(const Vec3& wo) { return {-wo.x, -wo.y, wo.z}; }

// The reflectance of a conductor, unpolarised; eta + i k: its index of refraction over that of what is in front.
inline double fresnel_conductor(double cos_incident, double eta, double k) {
  double c = std::clamp(cos_incident, 0.0, 1.0), c2 = c * c, sin2 = (1.0 - c) * (1.0 + c);
  double t = (eta - k) * (eta + k) - sin2;
  double length = std::sqrt(t * t + 4.0 * eta * eta * k * k);  // of the complex number whose root is a + i b
  // Its real part; that of the two forms in which nothing cancels.
  double a = t >= 0.0 ? std::sqrt(0.5 * (length + t)) : eta * k / std::sqrt(0.5 * (length - t));
  double p = length + c2, q = 2.0 * a * c;
  double across = (p - q) / (p + q);
  double u = c2 * length + sin2 * sin2, v = q * sin2;
  return 0.5 * across * (1.0 + (u - v) / (u + v));
}

// Schlick's approximation for conductors given by their reflectance at normal incidence.
inline Rgb fresnel_schlick(const Rgb& reflectance, double cos_incident) {
  double m = std::clamp(1.0 - cos_incident, 0.0, 1.0);
  double m2 = m * m;
  return reflectance + (Rgb(1.0) - reflectance) * (m2 * m2 * m);
}

}  // namespace tilecast
