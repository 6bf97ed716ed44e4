// The colour of a surface by itself, as denoisers and compositors want it: the share of light that leaves it again.
#pragma once

#include "shading/bsdf.h"

namespace tilecast {

// 0 to 1 in each channel. Clear glass is white: all light that meets it goes on, to one side or the other.
inline Rgb albedo_at(const Scene& scene, const Surface& surface) {
  return surface.material->kind == MaterialKind::Dielectric ? Rgb(1.0) : reflectance_at(scene, surface);
}

}  // namespace tilecast
