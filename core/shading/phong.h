// Phong's model, normalised and reciprocal: Lafortune and Willems, "Using the Modified Phong Reflectance Model for
// Physically Based Rendering", report CW197, KU Leuven, 1994.
#pragma once

#include "scene/material.h"
#include "shading/basis.h"
#include "shading/hemisphere.h"
#include "shading/sample.h"

namespace tilecast {

class Phong {
 public:
  Phong(const Material& material, const Rgb& reflectance)
      : diffuse_(reflectance), specular_(material.specular), exponent_(material.exponent) {
    double d = max_component(diffuse_), s = max_component(specular_);
    share_ = d + s > 0.0 ? s / (d + s) : 0.0;
  }

  // f |cos|, and the density with which sample() takes wi.
  Rgb evaluate(const Vec3& wo, const Vec3& wi, double& pdf) const {
    double cosine = wo.z * wi.z - wo.x * wi.x - wo.y * wi.y;  // with the mirrored direction
    double lobe = cosine > 0.0 ? power_of_unit(std::min(1.0, cosine), exponent_) * 0.5 * kInvPi : 0.0;
    pdf = share_ * (exponent_ + 1.0) * lobe + (1.0 - share_) * wi.z * kInvPi;
    return (diffuse_ * kInvPi + specular_ * ((exponent_ + 2.0) * lobe)) * wi.z;
  }

  bool sample(const Vec3& wo, Sampler& sampler, BsdfSample& out) const {
    if (sampler.next1() < share_) {
      Vec2 u = sampler.next2();
      double cosine = power_of_unit(1.0 - u.x, 1.0 / (exponent_ + 1.0)), sine = std::sqrt(1.0 - cosine * cosine);
      double s, c;
      sincos_2pi(u.y, s, c);
      out.wi = Basis({-wo.x, -wo.y, wo.z}).to_world({sine * c, sine * s, cosine});
    } else {
      out.wi = cosine_hemisphere(sampler.next2());
    }
    return out.wi.z > 0.0 && weigh(*this, wo, out);
  }

 private:
  Rgb diffuse_, specular_;
  double exponent_, share_;  // share_: of the samples, about the mirrored direction
};

}  // namespace tilecast
