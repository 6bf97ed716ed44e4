#include "shading/bsdf.h"

#include "base/counters.h"
#include "shading/hemisphere.h"
#include "shading/microfacet.h"

namespace tilecast {
Rgb reflectance_at(const Scene& scene, const Surface& surface) {
  const Material& material = *surface.material;
  if (material.texture < 0) return material.reflectance;
  TILECAST_COUNT(texture);
  const Checker& checker = scene.checkers[material.texture];
  // A step inwards keeps faces that lie on a wall between two cells in one of them.
  return checker.at(surface.local_point - 1e-6 * checker.size * glm::normalize(surface.local_normal));
}

Rgb Bsdf::evaluate(const Vec3& wo, const Vec3& wi, double& pdf) const {
  pdf = 0.0;
  if (wi.z <= 0.0 || wo.z <= 0.0 || specular()) return Rgb(0.0);
  if (kind_ == MaterialKind::Diffuse) {
    pdf = wi.z * kInvPi;
    return reflectance_ * pdf;
  }
  Ggx ggx(roughness_);
  Vec3 m = glm::normalize(wo + wi);
  pdf = ggx.reflected_pdf(wo, m);
  return fresnel_conductor(reflectance_, glm::dot(wo, m)) *
         (ggx.density(m) * ggx.visible(wo, wi) / (4.0 * wo.z));
}

bool Bsdf::sample(const Vec3& wo, Sampler& sampler, BsdfSample& out) const {
  switch (kind_) {
    case MaterialKind::Diffuse:
      out.wi = cosine_hemisphere(sampler.next2());
      out.pdf = out.wi.z * kInvPi;
      out.weight = reflectance_;
      out.specular = false;
      return out.wi.z > 0.0;
    case MaterialKind::Mirror:
      out = {reflect(wo), reflectance_, 0.0, true};
      return true;
    case MaterialKind::Conductor: {
      if (roughness_ == 0.0) {
        out = {reflect(wo), fresnel_conductor(reflectance_, wo.z), 0.0, true};
        return true;
      }
      Ggx ggx(roughness_);
      Vec3 m = ggx.sample_normal(wo, sampler.next2());
      Vec3 wi = 2.0 * glm::dot(wo, m) * m - wo;
      if (wi.z <= 0.0) return false;
      // Of the density only the masking of wi is left.
      double lambda = ggx.lambda(wo);
      out = {wi, fresnel_conductor(reflectance_, glm::dot(wo, m)) * (ggx.visible(wo, wi) * (1.0 + lambda)),
             ggx.reflected_pdf(wo, m), false};
      return out.pdf > 0.0;
    }
    default: {
      Fresnel fresnel = fresnel_dielectric(wo.z, eta_);
      if (fresnel.total || sampler.next1() < fresnel.reflectance)
        out = {reflect(wo), Rgb(1.0), 0.0, true};
      else  // radiance is squeezed into a smaller cone on the denser side
        out = {refract(wo, eta_, fresnel.cos_transmitted), Rgb(1.0 / (eta_ * eta_)), 0.0, true};
      return true;
    }
  }
}

}  // namespace tilecast
