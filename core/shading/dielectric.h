// A dielectric with a rough surface: Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR
// 2007; and what meets more than one microfacet (see optics/energy.h), shared between the two sides so that the whole
// is reciprocal.
#pragma once

#include "optics/energy.h"
#include "optics/fresnel.h"
#include "optics/microfacet.h"
#include "shading/hemisphere.h"
#include "shading/sample.h"

namespace tilecast {

class RoughDielectric {
 public:
  // eta: index of refraction beyond the surface over that here, on the side of wo.
  RoughDielectric(double roughness, double eta, const Rgb& tint, const SideEnergy& here, const SideEnergy& beyond)
      : ggx_(roughness), eta_(eta), tint_(tint), here_(here), beyond_(beyond) {}

  // f |cos|, and the density with which sample() takes wi.
  Rgb evaluate(const Vec3& wo, const Vec3& wi, double& pdf) const {
    const double lost = here_.loss.at(wo.z), around = std::fabs(wi.z) * kInvPi;
    if (wi.z > 0.0) {
      Vec3 m = glm::normalize(wo + wi);
      double reflectance = fresnel_dielectric(std::min(1.0, glm::dot(wo, m)), eta_).reflectance;
      double multiple = 1.0 - here_.transmitted;
      pdf = (1.0 - lost) * reflectance * ggx_.reflected_pdf(wo, m) + lost * multiple * around;
      double f = reflectance * ggx_.density(m) * ggx_.visible(wo, wi) / (4.0 * wo.z);
      if (lost > 0.0) f += multiple * lost * here_.loss.at(wi.z) / here_.loss.average() * around;
      return Rgb(f);
    }
    pdf = lost * here_.transmitted * around;
    double f = lost > 0.0 ? pdf * beyond_.loss.at(-wi.z) / beyond_.loss.average() : 0.0;
    Vec3 h = wo + eta_ * wi;  // in Walter's equation 16, up to the sign
    double length2 = glm::dot(h, h);
    if (Vec3 m = h * (std::copysign(1.0, h.z) / std::sqrt(length2)); glm::dot(wo, m) > 0.0 && glm::dot(wi, m) < 0.0) {
      double c = std::min(1.0, glm::dot(wo, m));
      double once = (1.0 - fresnel_dielectric(c, eta_).reflectance) * ggx_.seen_density(wo, m) * c * eta_ * eta_ *
                    -glm::dot(wi, m) / length2;
      pdf += (1.0 - lost) * once;
      f += once * ggx_.visible_of_seen(wo, wi);
    }
    return tint_ * (f / (eta_ * eta_));
  }

  bool sample(const Vec3& wo, Sampler& sampler, BsdfSample& out) const {
    if (sampler.next1() < here_.loss.at(wo.z)) {
      out.wi = cosine_hemisphere(sampler.next2());
      if (sampler.next1() < here_.transmitted) out.wi = -out.wi;
    } else {
      Vec3 m = ggx_.sample_normal(wo, sampler.next2());
      double c = std::min(1.0, glm::dot(wo, m));
      if (!(c > 0.0)) return false;
      Fresnel fresnel = fresnel_dielectric(c, eta_);
      bool reflects = fresnel.total || sampler.next1() < fresnel.reflectance;
      out.wi = reflects ? 2.0 * c * m - wo : (c / eta_ - fresnel.cos_transmitted) * m - wo / eta_;
      if (reflects != (out.wi.z > 0.0)) return false;
    }
    return weigh(*this, wo, out);
  }

 private:
  Ggx ggx_;
  double eta_;
  Rgb tint_;
  const SideEnergy &here_, &beyond_;
};

}  // namespace tilecast
