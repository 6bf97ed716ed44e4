// The GGX microfacet distribution (isotropic), in the local frame: z is the normal.
//
// Walter et al. 2007; Smith's height-correlated masking (Heitz 2014); normals sampled by what is visible from wo
// (Dupuy and Benyoub, "Sampling Visible GGX Normals with Spherical Caps", 2023).
#pragma once

#include "base/elementary.h"

namespace tilecast {

class Ggx {
 public:
  explicit Ggx(double roughness) : alpha_(roughness * roughness) {}

  double density(const Vec3& m) const {  // without the difference that cancels where alpha is small
    double a2 = alpha_ * alpha_;
    double k = m.x * m.x + m.y * m.y + a2 * m.z * m.z;
    return a2 / (kPi * k * k);
  }
  double lambda(const Vec3& w) const {
    double t2 = (w.x * w.x + w.y * w.y) / (w.z * w.z);
    return 0.5 * (std::sqrt(1.0 + alpha_ * alpha_ * t2) - 1.0);
  }
  // The share of microfacets seen from both directions, on one side or on two.
  double visible(const Vec3& wo, const Vec3& wi) const { return 1.0 / (1.0 + lambda(wo) + lambda(wi)); }
  // The same, of those seen from wo.
  double visible_of_seen(const Vec3& wo, const Vec3& wi) const {
    double seen = 1.0 + lambda(wo);
    return seen / (seen + lambda(wi));
  }
  // The density of sample_normal, over the cosine between wo and m.
  double seen_density(const Vec3& wo, const Vec3& m) const { return density(m) / ((1.0 + lambda(wo)) * wo.z); }
  // The density of reflected directions when the microfacet is sampled by sample_normal.
  double reflected_pdf(const Vec3& wo, const Vec3& m) const { return 0.25 * seen_density(wo, m); }
  Vec3 sample_normal(const Vec3& wo, const Vec2& u) const {
    Vec3 v = glm::normalize(Vec3(alpha_ * wo.x, alpha_ * wo.y, wo.z));
    double sine, cosine;
    sincos_2pi(u.x, sine, cosine);
    double z = std::fma(1.0 - u.y, 1.0 + v.z, -v.z);
    double r = std::sqrt(std::clamp(1.0 - z * z, 0.0, 1.0));
    Vec3 h = Vec3(r * cosine, r * sine, z) + v;
    return glm::normalize(Vec3(alpha_ * h.x, alpha_ * h.y, std::max(h.z, 1e-300)));
  }
  // The direction into which the normal that sample_normal takes reflects; below the surface where that is lost.
  Vec3 sample_reflected(const Vec3& wo, const Vec2& u) const {
    Vec3 m = sample_normal(wo, u);
    return 2.0 * glm::dot(wo, m) * m - wo;
  }

 private:
  double alpha_;
};

}  // namespace tilecast
