#include "shading/bsdf.h"

#include "base/counters.h"
#include "shading/coat.h"
#include "shading/conductor.h"
#include "shading/dielectric.h"
#include "shading/diffuse.h"
#include "shading/phong.h"

namespace tilecast {
Rgb reflectance_at(const Scene& scene, const Surface& surface, const Material& material) {
  if (material.texture < 0) return material.reflectance;
  TILECAST_COUNT(texture);
  const Checker& checker = scene.checkers[material.texture];
  // A step inwards keeps faces that lie on a wall between two cells in one of them.
  return checker.at(surface.local_point - 1e-6 * checker.size * glm::normalize(surface.local_normal));
}

bool Bsdf::rough_glass() const { return !material_.smooth() && std::fabs(boundary_.eta - 1.0) >= kLeastContrast; }

bool Bsdf::is_specular() const {
  switch (material_.kind) {
    case MaterialKind::Mirror: return true;
    case MaterialKind::Conductor: return material_.smooth();
    case MaterialKind::Dielectric: return !rough_glass();
    case MaterialKind::Blend:
      for (int i = 0; i < Material::kMostParts; ++i)
        if (material_.shares[i] > 0.0 && !part(i).specular()) return false;
      return true;
    default: return false;
  }
}

RoughConductor Bsdf::rough_conductor() const {
  return {material_, reflectance_, scene_.conductor_losses[material_.energy]};
}

Plastic Bsdf::plastic() const { return {material_, reflectance_, scene_.coat_energies[material_.energy]}; }

RoughDielectric Bsdf::rough_dielectric() const {
  const int beside = boundary_.beside ? boundary_.beside->medium : 0;
  const DielectricEnergy& energy = scene_.dielectric_energies[scene_.pairs[material_.energy + beside]];
  const SideEnergy &here = boundary_.entering ? energy.front : energy.back;
  const SideEnergy &beyond = boundary_.entering ? energy.back : energy.front;
  return {material_.roughness, boundary_.eta, tint(), here, beyond};
}

int Bsdf::choose_part(Sampler& sampler) const {
  double u = sampler.next1();
  int chosen = 0;
  for (int i = 0; i < Material::kMostParts; ++i) {
    if (!(material_.shares[i] > 0.0)) continue;
    chosen = i;
    if ((u -= material_.shares[i]) < 0.0) break;
  }
  return chosen;
}

Rgb Bsdf::evaluate_any(const Vec3& wo, const Vec3& wi, double& pdf) const {
  pdf = 0.0;
  if (specular_) return Rgb(0.0);
  if (wi.z <= 0.0) {
    if (wi.z == 0.0 || !material_.refracts) return Rgb(0.0);
    if (material_.kind == MaterialKind::Dielectric) return rough_dielectric().evaluate(wo, wi, pdf);
  }
  switch (material_.kind) {
    case MaterialKind::Diffuse:
      pdf = wi.z * kInvPi;
      return OrenNayar(reflectance_, material_.roughness).evaluate(wo, wi);
    case MaterialKind::Conductor: return rough_conductor().evaluate(wo, wi, pdf);
    case MaterialKind::Dielectric: return rough_dielectric().evaluate(wo, wi, pdf);
    case MaterialKind::Plastic: return plastic().evaluate(wo, wi, pdf);
    case MaterialKind::Phong: return Phong(material_, reflectance_).evaluate(wo, wi, pdf);
    case MaterialKind::Blend: {
      Rgb sum(0.0);
      for (int i = 0; i < Material::kMostParts; ++i) {
        if (!(material_.shares[i] > 0.0)) continue;
        double density;
        sum += material_.shares[i] * part(i).evaluate(wo, wi, density);
        pdf += material_.shares[i] * density;
      }
      return sum;
    }
    default: return Rgb(0.0);
  }
}

bool Bsdf::sample_any(const Vec3& wo, Sampler& sampler, BsdfSample& out) const {
  switch (material_.kind) {
    case MaterialKind::Diffuse:
      out.wi = cosine_hemisphere(sampler.next2());
      if (!(out.wi.z > 0.0)) return false;
      out.pdf = out.wi.z * kInvPi;
      out.weight = OrenNayar(reflectance_, material_.roughness).evaluate(wo, out.wi) / out.pdf;
      out.specular = false;
      return true;
    case MaterialKind::Mirror:
      out = {reflect(wo), reflectance_, 0.0, true};
      return true;
    case MaterialKind::Conductor:
      if (!specular_) return rough_conductor().sample(wo, sampler, out);
      out = {reflect(wo), reflectance_of(material_, reflectance_, wo.z), 0.0, true};
      return true;
    case MaterialKind::Plastic: return plastic().sample(wo, sampler, out);
    case MaterialKind::Phong: return Phong(material_, reflectance_).sample(wo, sampler, out);
    case MaterialKind::Blend: {
      int chosen = choose_part(sampler);
      if (!part(chosen).sample(wo, sampler, out)) return false;
      if (out.specular) return true;
      return weigh(*this, wo, out);
    }
    default: {
      if (!specular_) return rough_dielectric().sample(wo, sampler, out);
      const double eta = boundary_.eta;
      Fresnel fresnel = fresnel_dielectric(wo.z, eta);
      if (fresnel.total || sampler.next1() < fresnel.reflectance)
        out = {reflect(wo), Rgb(1.0), 0.0, true};
      else  // radiance is squeezed into a smaller cone on the denser side
        out = {refract(wo, eta, fresnel.cos_transmitted), tint() / (eta * eta), 0.0, true};
      return true;
    }
  }
}

int Bsdf::beams(const Vec3& wo, Beam out[kMostBeams]) const {
  switch (material_.kind) {
    case MaterialKind::Mirror: out[0] = {reflect(wo), reflectance_}; return 1;
    case MaterialKind::Conductor:
      if (!specular_) return 0;
      out[0] = {reflect(wo), reflectance_of(material_, reflectance_, wo.z)};
      return 1;
    case MaterialKind::Plastic:
      if (!material_.smooth()) return 0;
      out[0] = {reflect(wo), Rgb(plastic().mirrored(wo))};
      return 1;
    case MaterialKind::Dielectric: {
      if (!specular_) return 0;
      const double eta = boundary_.eta;
      Fresnel fresnel = fresnel_dielectric(wo.z, eta);
      out[0] = {reflect(wo), Rgb(fresnel.reflectance)};
      if (fresnel.total) return 1;
      out[1] = {refract(wo, eta, fresnel.cos_transmitted), tint() * ((1.0 - fresnel.reflectance) / (eta * eta))};
      return 2;
    }
    case MaterialKind::Blend: {
      int count = 0;
      for (int i = 0; i < Material::kMostParts; ++i) {
        if (!(material_.shares[i] > 0.0)) continue;
        int more = part(i).beams(wo, out + count);
        for (int k = 0; k < more; ++k) out[count + k].weight *= material_.shares[i];
        count += more;
      }
      return count;
    }
    default: return 0;
  }
}

bool Bsdf::sample_glossy(const Vec3& wo, Sampler& sampler, BsdfSample& out) const {
  switch (material_.kind) {
    case MaterialKind::Conductor:
    case MaterialKind::Dielectric: return !specular_ && sample(wo, sampler, out);
    case MaterialKind::Blend: return part(choose_part(sampler)).sample_glossy(wo, sampler, out);
    default: return false;
  }
}

}  // namespace tilecast
