#include "shading/bsdf.h"

#include "shading/coat.h"
#include "shading/conductor.h"
#include "shading/dielectric.h"
#include "shading/diffuse.h"
#include "shading/phong.h"

namespace tilecast {
namespace {

// In the frame of the surface, from that of the lobes; false where that lies on the other side.
bool leaves(const Basis& tilted, Vec3& wi) {
  const bool through = wi.z < 0.0;
  wi = glm::normalize(tilted.to_world(wi));
  return through ? wi.z < 0.0 : wi.z > 0.0;
}

// Of a viewer, whom the tilted normal may see edge-on.
Vec3 seen_from(const Basis& tilted, const Vec3& wo) {
  Vec3 out = tilted.to_local(wo);
  out.z = std::max(out.z, 1e-12);
  return out;
}

}  // namespace

void Bsdf::look_up() {
  reflectance_ = reflectance_at(scene_, surface_, material_);
  roughness_ = roughness_at(scene_, surface_, material_);
  if (!built_with("normal_map") || material_.normal_map < 0) return;
  mapped_ = true;
  lambert_ = false;
  const double side = surface_.front ? 1.0 : -1.0;
  normal_ = Basis(side * surface_.normal).to_local(side * surface_.shading_normal);
}

Basis Bsdf::tilted(const Vec3& wo) const {
  const Vec3 mirrored = 2.0 * glm::dot(normal_, wo) * normal_ - wo;
  const double lowest = std::min(0.01, 0.9 * wo.z);
  if (mirrored.z >= lowest) return Basis(normal_);
  return Basis(glm::normalize(wo + glm::normalize(Vec3(mirrored.x, mirrored.y, lowest))));
}

Rgb Bsdf::evaluate_any(const Vec3& wo, const Vec3& wi, double& pdf) const {
  if (!mapped()) return evaluate_lobes(wo, wi, pdf);
  const Basis basis = tilted(wo);
  const Vec3 local = basis.to_local(wi);
  pdf = 0.0;
  if (!(local.z * wi.z > 0.0)) return Rgb(0.0);
  return evaluate_lobes(seen_from(basis, wo), local, pdf);
}

SplitBsdf Bsdf::split_any(const Vec3& wo, const Vec3& wi) const {
  if (!mapped()) return split_lobes(wo, wi);
  const Basis basis = tilted(wo);
  const Vec3 local = basis.to_local(wi);
  return local.z * wi.z > 0.0 ? split_lobes(seen_from(basis, wo), local) : SplitBsdf{};
}

bool Bsdf::sample_any(const Vec3& wo, Sampler& sampler, BsdfSample& out) const {
  if (!mapped()) return sample_lobes(wo, sampler, out);
  const Basis basis = tilted(wo);
  return sample_lobes(seen_from(basis, wo), sampler, out) && leaves(basis, out.wi);
}

bool Bsdf::sample_glossy_any(const Vec3& wo, Sampler& sampler, BsdfSample& out) const {
  if (!mapped()) return sample_glossy_lobes(wo, sampler, out);
  const Basis basis = tilted(wo);
  return sample_glossy_lobes(seen_from(basis, wo), sampler, out) && leaves(basis, out.wi);
}

int Bsdf::beams_any(const Vec3& wo, Beam out[kMostBeams]) const {
  if (!mapped()) return beams_of_lobes(wo, out);
  const Basis basis = tilted(wo);
  int kept = 0;
  for (int i = 0, count = beams_of_lobes(seen_from(basis, wo), out); i < count; ++i)
    if (leaves(basis, out[i].wi)) out[kept++] = out[i];
  return kept;
}

bool Bsdf::rough_glass() const {
  return built_with("microfacets") && !material_.smooth() && std::fabs(boundary_.eta - 1.0) >= kLeastContrast;
}

bool Bsdf::is_specular() const {
  switch (kind()) {
    case MaterialKind::Mirror: return true;
    case MaterialKind::Conductor: return !built_with("microfacets") || is_smooth(roughness_);
    case MaterialKind::Dielectric: return !rough_glass();
    case MaterialKind::Blend:
      for (int i = 0; i < Material::kMostParts; ++i)
        if (material_.shares[i] > 0.0 && !part(i).specular()) return false;
      return true;
    default: return false;
  }
}

// The tables of the roughnesses next to that of the texture, and how far it lies between them.
double Bsdf::roughness_level(int& low, int& high) const {
  const int most = static_cast<int>(std::ceil(material_.roughness * kRoughnessLevels)) - material_.first_level;
  const double level = roughness_ * kRoughnessLevels - material_.first_level;
  const int below = std::clamp(static_cast<int>(level), 0, most);
  low = scene_.roughness_levels[material_.energy + below];
  high = scene_.roughness_levels[material_.energy + std::min(below + 1, most)];
  return level - below;
}

RoughConductor Bsdf::rough_conductor() const {
  if (!built_with("microfacets")) __builtin_unreachable();
  if (!is_texture(material_.roughness_texture))
    return {material_, reflectance_, roughness_, scene_.conductor_losses[material_.energy]};
  int low, high;
  const double share = roughness_level(low, high);
  return {material_, reflectance_, roughness_, {scene_.conductor_losses[low], scene_.conductor_losses[high], share}};
}

Plastic Bsdf::plastic() const {
  int low = material_.energy, high = low;
  const double share = is_texture(material_.roughness_texture) ? roughness_level(low, high) : 0.0;
  const CoatEnergy &below = scene_.coat_energies[low], &above = scene_.coat_energies[high];
  return {material_.ior, reflectance_, roughness_, {below.reflection, above.reflection, share}, below.inner};
}

RoughDielectric Bsdf::rough_dielectric() const {
  if (!built_with("microfacets")) __builtin_unreachable();
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

Rgb Bsdf::evaluate_lobes(const Vec3& wo, const Vec3& wi, double& pdf) const {
  pdf = 0.0;
  if (specular_) return Rgb(0.0);
  if (wi.z <= 0.0) {
    if (wi.z == 0.0 || !refracts(material_)) return Rgb(0.0);
    if (kind() == MaterialKind::Dielectric) return rough_dielectric().evaluate(wo, wi, pdf);
  }
  switch (kind()) {
    case MaterialKind::Diffuse:
      pdf = wi.z * kInvPi;
      if (!built_with("oren_nayar") || roughness_ == 0.0) return reflectance_ * pdf;
      return OrenNayar(reflectance_, roughness_).evaluate(wo, wi);
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

SplitBsdf Bsdf::split_lobes(const Vec3& wo, const Vec3& wi) const {
  SplitBsdf out;
  if (kind() == MaterialKind::Blend) {
    for (int i = 0; i < Material::kMostParts; ++i) {
      const double share = material_.shares[i];
      if (!(share > 0.0)) continue;
      const SplitBsdf found = part(i).split(wo, wi);
      out.glossy += share * found.glossy;
      out.pdf += share * found.pdf;
      out.other += share * found.other;
    }
    return out;
  }
  double pdf;
  const Rgb f = evaluate_lobes(wo, wi, pdf);
  if (kind() == MaterialKind::Conductor || kind() == MaterialKind::Dielectric)
    out.glossy = f, out.pdf = pdf;
  else
    out.other = f;
  return out;
}

bool Bsdf::sample_lobes(const Vec3& wo, Sampler& sampler, BsdfSample& out) const {
  switch (kind()) {
    case MaterialKind::Diffuse:
      out.wi = cosine_hemisphere(sampler.next2());
      return out.wi.z > 0.0 && weigh(*this, wo, out, &Bsdf::evaluate_lobes);
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
      return out.specular || weigh(*this, wo, out, &Bsdf::evaluate_lobes);
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

int Bsdf::beams_of_lobes(const Vec3& wo, Beam out[kMostBeams]) const {
  switch (kind()) {
    case MaterialKind::Mirror: out[0] = {reflect(wo), reflectance_}; return 1;
    case MaterialKind::Conductor:
      if (!specular_) return 0;
      out[0] = {reflect(wo), reflectance_of(material_, reflectance_, wo.z)};
      return 1;
    case MaterialKind::Plastic:
      if (!is_smooth(roughness_)) return 0;
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

bool Bsdf::sample_glossy_lobes(const Vec3& wo, Sampler& sampler, BsdfSample& out) const {
  switch (kind()) {
    case MaterialKind::Conductor:
    case MaterialKind::Dielectric: return !specular_ && sample(wo, sampler, out);
    case MaterialKind::Blend:
      if (!part(choose_part(sampler)).sample_glossy(wo, sampler, out)) return false;
      out.pdf = split_lobes(wo, out.wi).pdf;
      return true;
    default: return false;
  }
}

}  // namespace tilecast
