// Scattering at one point of a surface, in the local frame whose z axis is the normal on the viewer's side.
//
// With a normal map the lobes stand about the map's normal. Directions must lie on the same side of it as of the surface
// itself: what is scattered to the other side is lost, so that no light leaks through, and none is made. Where a mirror
// about the map's normal would point into the surface, the normal is turned until that grazes it: Keller et al., "The
// Iray Light Transport Simulation and Rendering System", SIGGRAPH 2017 talks, appendix A.3.
#pragma once

#include "shading/basis.h"
#include "shading/hemisphere.h"
#include "shading/medium.h"
#include "shading/sample.h"
#include "shading/textured.h"

namespace tilecast {

class Plastic;
class RoughConductor;
class RoughDielectric;

// A single direction into which a part of the light goes, as from a mirror or through glass.
struct Beam {
  Vec3 wi;
  Rgb weight;  // f |cos| / density, all of it
};
inline constexpr int kMostBeams = 2 * Material::kMostParts;

// f |cos| of a pair of directions without the single ones, in two parts.
struct SplitBsdf {
  Rgb glossy{0.0};   // what sample_glossy() takes
  double pdf = 0.0;  // its density
  Rgb other{0.0};
};

class Bsdf {
 public:
  Bsdf(const Scene& scene, const Surface& surface, const Boundary& boundary)
      : Bsdf(scene, surface, *surface.material, boundary) {}

  // Scatters into single directions alone: no light can be connected to.
  bool specular() const { return specular_; }

  // f |cos| of a pair of directions without the single ones, and the density with which sample() takes wi.
  // wo.z > 0.
  Rgb evaluate(const Vec3& wo, const Vec3& wi, double& pdf) const {
    if (!lambert_) return evaluate_any(wo, wi, pdf);
    pdf = std::max(0.0, wi.z) * kInvPi;
    return reflectance_ * pdf;
  }

  // The same in two parts.
  SplitBsdf split(const Vec3& wo, const Vec3& wi) const {
    if (!lambert_) return split_any(wo, wi);
    return {Rgb(0.0), 0.0, reflectance_ * (std::max(0.0, wi.z) * kInvPi)};
  }

  // False where nothing is scattered. wo.z > 0.
  bool sample(const Vec3& wo, Sampler& sampler, BsdfSample& out) const {
    if (!lambert_) return sample_any(wo, sampler, out);
    out.wi = cosine_hemisphere(sampler.next2());
    out.pdf = out.wi.z * kInvPi;
    out.weight = reflectance_;
    return out.wi.z > 0.0;
  }

  // The single directions; how many there are.
  int beams(const Vec3& wo, Beam out[kMostBeams]) const { return lambert_ ? 0 : beams_any(wo, out); }

  // Of what is scattered about such directions, as by a rough metal or rough glass; false where there is nothing. The
  // density is that of all such parts together, of which one is taken.
  bool sample_glossy(const Vec3& wo, Sampler& sampler, BsdfSample& out) const {
    return !lambert_ && sample_glossy_any(wo, sampler, out);
  }

 private:
  Bsdf(const Scene& scene, const Surface& surface, const Material& material, const Boundary& boundary)
      : scene_(scene), surface_(surface), material_(material), boundary_(boundary),
        reflectance_(material.reflectance), roughness_(material.roughness),
        lambert_(kind() == MaterialKind::Diffuse && !(built_with("oren_nayar") && material.roughness > 0.0)) {
    if (built_with("texture") && material.textured) look_up();
    specular_ = !lambert_ && is_specular();
  }

  Bsdf part(int i) const { return {scene_, surface_, scene_.materials[material_.parts[i]], boundary_}; }
  Rgb tint() const { return is_texture(material_.texture) ? reflectance_ : material_.tint; }
  // None that the build leaves out.
  MaterialKind kind() const {
    const MaterialKind kind = material_.kind;
    if ((kind == MaterialKind::Mirror && !built_with("mirror")) ||
        (kind == MaterialKind::Conductor && !built_with("conductor")) ||
        (kind == MaterialKind::Dielectric && !built_with("dielectric")) ||
        (kind == MaterialKind::Plastic && !built_with("plastic")) || (kind == MaterialKind::Phong && !built_with("phong")) ||
        (kind == MaterialKind::Blend && !built_with("blend")))
      __builtin_unreachable();
    return kind;
  }
  bool mapped() const { return built_with("normal_map") && mapped_; }
  void look_up();
  Rgb evaluate_any(const Vec3& wo, const Vec3& wi, double& pdf) const;
  SplitBsdf split_any(const Vec3& wo, const Vec3& wi) const;
  bool sample_any(const Vec3& wo, Sampler& sampler, BsdfSample& out) const;
  bool sample_glossy_any(const Vec3& wo, Sampler& sampler, BsdfSample& out) const;
  int beams_any(const Vec3& wo, Beam out[kMostBeams]) const;
  // About the normal that the lobes stand about.
  Rgb evaluate_lobes(const Vec3& wo, const Vec3& wi, double& pdf) const;
  SplitBsdf split_lobes(const Vec3& wo, const Vec3& wi) const;
  bool sample_lobes(const Vec3& wo, Sampler& sampler, BsdfSample& out) const;
  bool sample_glossy_lobes(const Vec3& wo, Sampler& sampler, BsdfSample& out) const;
  int beams_of_lobes(const Vec3& wo, Beam out[kMostBeams]) const;
  Basis tilted(const Vec3& wo) const;
  int choose_part(Sampler& sampler) const;
  bool is_specular() const;
  bool rough_glass() const;
  double roughness_level(int& low, int& high) const;
  RoughConductor rough_conductor() const;
  RoughDielectric rough_dielectric() const;  // with the energies of the two media that meet here
  Plastic plastic() const;

  const Scene& scene_;
  const Surface& surface_;
  const Material& material_;
  const Boundary& boundary_;
  Rgb reflectance_;
  double roughness_;
  Vec3 normal_;          // of the normal map, where there is one
  bool mapped_ = false;  // there is
  bool lambert_;  // the commonest kind, which is not to wait for the others
  bool specular_;
};

}  // namespace tilecast
