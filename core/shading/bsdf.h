// Scattering at one point of a surface, in the local frame whose z axis is the normal on the viewer's side.
#pragma once

#include "base/sampler.h"
#include "shading/basis.h"
#include "shading/fresnel.h"
#include "scene/surface.h"

namespace tilecast {

// What the texture or the material says at this point.
Rgb reflectance_at(const Scene& scene, const Surface& surface);

struct BsdfSample {
  Vec3 wi;            // local frame; wi.z < 0: through the surface
  Rgb weight;         // f |cos| / density
  double pdf = 0.0;   // per solid angle; not used where `specular`
  bool specular = false;
};

class Bsdf {
 public:
  // eta: index of refraction behind the surface over that in front of it; dielectrics alone use it.
  Bsdf(const Material& material, const Rgb& reflectance, double eta)
      : kind_(material.kind), reflectance_(reflectance), roughness_(material.roughness), eta_(eta) {}

  // Scatters into single directions: no light can be connected to.
  bool specular() const {
    return kind_ == MaterialKind::Mirror || kind_ == MaterialKind::Dielectric ||
           (kind_ == MaterialKind::Conductor && roughness_ == 0.0);
  }

  // f |cos| of a pair of directions, and the density with which sample() takes wi.
  Rgb evaluate(const Vec3& wo, const Vec3& wi, double& pdf) const;

  // False where nothing is scattered. wo.z > 0.
  bool sample(const Vec3& wo, Sampler& sampler, BsdfSample& out) const;

 private:
  MaterialKind kind_;
  Rgb reflectance_;
  double roughness_, eta_;
};

}  // namespace tilecast
