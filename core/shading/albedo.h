// The colour of a surface by itself, as denoisers and compositors want it: the share of light that leaves it again.
#pragma once

#include "shading/bsdf.h"

namespace tilecast {

// 0 to 1 in each channel. Clear glass is white: all light that meets it goes on, to one side or the other.
inline Rgb albedo_at(const Scene& scene, const Surface& surface, const Material& material) {
  const Rgb reflectance = reflectance_at(scene, surface, material);
  switch (material.kind) {
    case MaterialKind::Dielectric: return material.texture < 0 ? material.tint : reflectance;
    case MaterialKind::Conductor: return material.eta.x > 0.0 ? material.average : reflectance;
    case MaterialKind::Phong: return reflectance + material.specular;
    case MaterialKind::Blend: {
      Rgb sum(0.0);
      for (int i = 0; i < Material::kMostParts; ++i)
        if (material.shares[i] > 0.0)
          sum += material.shares[i] * albedo_at(scene, surface, scene.materials[material.parts[i]]);
      return sum;
    }
    default: return reflectance;
  }
}

}  // namespace tilecast
