// Plastic: pigment under a dielectric coat, smooth or rough.
//
// What the coat does not reflect gets in, is reflected diffusely, and gets out or is reflected back down, again and
// again. Both ways through the coat weigh as 1 less its reflection, after Kelemen and Szirmay-Kalos, "A Microfacet
// Based Coupled Specular-Matte BRDF Model", Eurographics short papers, 2001; the sum over the inner reflections is that
// of a uniform radiance. White pigment then gives back all light.
#pragma once

#include "base/built.h"
#include "optics/energy_between.h"
#include "optics/fresnel.h"
#include "optics/microfacet.h"
#include "scene/material.h"
#include "shading/hemisphere.h"
#include "shading/sample.h"

namespace tilecast {

class Plastic {
 public:
  // reflection: of the coat; inner: of diffuse light from below, back down.
  Plastic(double ior, const Rgb& reflectance, double roughness, const EnergyBetween& reflection, double inner)
      : ior_(ior), smooth_(!built_with("microfacets") || is_smooth(roughness)), ggx_(roughness), reflection_(reflection),
        body_(reflectance * (1.0 - inner) / (1.0 - reflectance * inner)) {}

  // By the smooth coat, in one direction.
  double mirrored(const Vec3& wo) const { return smooth_ ? reflection(wo.z) : 0.0; }

  // f |cos| but for a smooth coat's own reflection, and the density with which sample() takes wi.
  Rgb evaluate(const Vec3& wo, const Vec3& wi, double& pdf) const {
    const double coat = share_of_coat(wo), around = wi.z * kInvPi;
    pdf = (1.0 - coat) * around;
    const double in = 1.0 - reflection(wi.z), out = 1.0 - reflection(wo.z), average = 1.0 - reflection_.average();
    Rgb f = body_ * (in * out / average * around);
    if (smooth_) return f;
    Vec3 m = glm::normalize(wo + wi);
    pdf += coat * ggx_.reflected_pdf(wo, m);
    return f + fresnel_dielectric(std::min(1.0, glm::dot(wo, m)), ior_).reflectance * ggx_.density(m) *
                   ggx_.visible(wo, wi) / (4.0 * wo.z);
  }

  bool sample(const Vec3& wo, Sampler& sampler, BsdfSample& out) const {
    const double coat = share_of_coat(wo);
    if (!(sampler.next1() < coat)) {
      out.wi = cosine_hemisphere(sampler.next2());
    } else if (smooth_) {
      out = {reflect(wo), Rgb(reflection(wo.z) / coat), 0.0, true};
      return true;
    } else {
      out.wi = ggx_.sample_reflected(wo, sampler.next2());
    }
    return out.wi.z > 0.0 && weigh(*this, wo, out);
  }

 private:
  double reflection(double cosine) const {
    return smooth_ ? fresnel_dielectric(std::min(1.0, cosine), ior_).reflectance : reflection_.at(cosine);
  }
  // How often sample() takes the coat: as much as it reflects of all that is reflected.
  double share_of_coat(const Vec3& wo) const {
    double coat = reflection(wo.z), body = (1.0 - coat) * max_component(body_);
    return coat + body > 0.0 ? coat / (coat + body) : 1.0;
  }

  double ior_;
  bool smooth_;
  Ggx ggx_;
  EnergyBetween reflection_;
  Rgb body_;  // reflected in the end, of what gets in
};

}  // namespace tilecast
