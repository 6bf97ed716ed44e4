// A rough metal: microfacets of GGX's distribution, and what they reflect more than once (see optics/energy.h).
#pragma once

#include "optics/energy_between.h"
#include "optics/fresnel.h"
#include "optics/microfacet.h"
#include "scene/material.h"
#include "shading/hemisphere.h"
#include "shading/sample.h"

namespace tilecast {

// At an angle; by the metal's complex index of refraction where it has one.
inline Rgb reflectance_of(const Material& metal, const Rgb& reflectance, double cosine) {
  if (!(metal.eta.x > 0.0)) return fresnel_schlick(reflectance, cosine);
  Rgb out;
  for (int i = 0; i < 3; ++i) out[i] = fresnel_conductor(cosine, metal.eta[i], metal.k[i]);
  return out;
}

class RoughConductor {
 public:
  RoughConductor(const Material& metal, const Rgb& reflectance, double roughness, const EnergyBetween& loss)
      : metal_(metal), reflectance_(reflectance), ggx_(roughness), loss_(loss) {}

  // f |cos|, and the density with which sample() takes wi.
  Rgb evaluate(const Vec3& wo, const Vec3& wi, double& pdf) const {
    Vec3 m = glm::normalize(wo + wi);
    double lost = loss_.at(wo.z), average = loss_.average(), around = wi.z * kInvPi;
    pdf = (1.0 - lost) * ggx_.reflected_pdf(wo, m) + lost * around;
    Rgb f = reflectance_of(metal_, reflectance_, glm::dot(wo, m)) *
            (ggx_.density(m) * ggx_.visible(wo, wi) / (4.0 * wo.z));
    if (lost == 0.0) return f;
    // The series of reflections, each by the average reflectance, of which the share 1 - average gets out.
    Rgb fresnel = metal_.eta.x > 0.0 ? metal_.average : (20.0 * reflectance_ + 1.0) / 21.0;
    Rgb multiple = fresnel * fresnel * (1.0 - average) / (1.0 - fresnel * average);
    return f + multiple * (lost * loss_.at(wi.z) / average * around);
  }

  bool sample(const Vec3& wo, Sampler& sampler, BsdfSample& out) const {
    if (sampler.next1() < loss_.at(wo.z)) {
      out.wi = cosine_hemisphere(sampler.next2());
    } else {
      out.wi = ggx_.sample_reflected(wo, sampler.next2());
    }
    return out.wi.z > 0.0 && weigh(*this, wo, out);
  }

 private:
  const Material& metal_;
  Rgb reflectance_;
  Ggx ggx_;
  EnergyBetween loss_;
};

}  // namespace tilecast
