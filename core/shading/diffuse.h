// Diffuse reflection of rough matter, the energy-preserving form of Oren and Nayar's: Portsmouth, Kutz and Hill, "EON: A
// Practical Energy-Preserving Rough Diffuse BRDF", JCGT 14(1), 2025, with the exact albedo.
#pragma once

#include "base/elementary.h"
#include "shading/hemisphere.h"

namespace tilecast {

class OrenNayar {
 public:
  OrenNayar(const Rgb& reflectance, double roughness)
      : reflectance_(reflectance), roughness_(roughness), flat_(1.0 / (1.0 + kFirst * roughness)) {}

  // f |cos|, of two directions above the surface.
  Rgb evaluate(const Vec3& wo, const Vec3& wi) const {
    double s = wo.x * wi.x + wo.y * wi.y;
    double single = flat_ * (1.0 + roughness_ * (s > 0.0 ? s / std::max(wo.z, wi.z) : s));
    double loss = flat_ * (kFirst - kSecond) * roughness_, average = 1.0 - loss;  // over all directions
    double lost = std::max(0.0, 1.0 - albedo(wo.z)) * std::max(0.0, 1.0 - albedo(wi.z)) / loss;
    Rgb multiple = reflectance_ * reflectance_ * (average * lost) / (1.0 - reflectance_ * loss);
    return (reflectance_ * single + multiple) * (wi.z * kInvPi);
  }

 private:
  // What a white surface reflects once.
  double albedo(double cosine) const {
    double c = std::min(cosine, 1.0), s = std::sqrt((1.0 - c) * (1.0 + c));
    double g = s * (acos_unit(c) - s * c) + (2.0 / 3.0) * (s * c * (1.0 + s + s * s) / (1.0 + s) - s);
    return flat_ * (1.0 + roughness_ * kInvPi * g);
  }

  static constexpr double kFirst = 0.5 - 2.0 / (3.0 * kPi), kSecond = 2.0 / 3.0 - 28.0 / (15.0 * kPi);

  Rgb reflectance_;
  double roughness_, flat_;
};

}  // namespace tilecast
