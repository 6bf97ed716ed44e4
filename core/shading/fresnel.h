// Fresnel reflection and refraction at a smooth dielectric boundary.
//
// Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007, equation 22, rearranged so that
// nothing cancels: with g = eta cos(theta_t), g - c is (eta^2 - 1) / (g + c), and c (g -+ c) +- 1 is c g +- sin^2.
// Whether the reflection is total is decided once, here.
#pragma once

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
  double eta2 = eta * eta, c2 = c * c;
  double rest = std::fma(eta, eta, -eta2) + std::fma(c, c, -c2);
  double g2 = (c2 >= 0.5 ? eta2 + (c2 - 1.0) : c2 + (eta2 - 1.0)) + rest;
  if (g2 <= 0.0) return {1.0, 0.0, true};
  double g = std::sqrt(g2);
  double sin2 = (1.0 - c) * (1.0 + c);
  double a = (eta - 1.0) * (eta + 1.0) / ((g + c) * (g + c));
  double b = (c * g - sin2) / (c * g + sin2);
  return {std::min(1.0, 0.5 * a * a * (1.0 + b * b)), g / eta, false};
}

// The refracted direction of one that arrives against the z axis: wo points away from the surface, wo.z > 0.
inline Vec3 refract(const Vec3& wo, double eta, double cos_transmitted) {
  return {-wo.x / eta, -wo.y / eta, -cos_transmitted};
}

inline Vec3 reflect(const Vec3& wo) { return {-wo.x, -wo.y, wo.z}; }

// Schlick's approximation for conductors given by their reflectance at normal incidence.
inline Rgb fresnel_conductor(const Rgb& reflectance, double cos_incident) {
  double m = std::clamp(1.0 - cos_incident, 0.0, 1.0);
  double m2 = m * m;
  return reflectance + (Rgb(1.0) - reflectance) * (m2 * m2 * m);
}

}  // namespace tilecast
