// A direction into which light is scattered, in the local frame whose z axis is the normal on the viewer's side.
#pragma once

#include "base/sampler.h"
#include "base/vec.h"

namespace tilecast {

struct BsdfSample {
  Vec3 wi;            // wi.z < 0: through the surface
  Rgb weight;         // f |cos| / density
  double pdf = 0.0;   // per solid angle; not used where `specular`
  bool specular = false;
};

// Gives a sample whose direction is chosen its density and weight, by what evaluates the lobe; false where the density
// is 0.
template <class Lobe>
bool weigh(const Lobe& lobe, const Vec3& wo, BsdfSample& out,
           Rgb (Lobe::*evaluate)(const Vec3&, const Vec3&, double&) const = &Lobe::evaluate) {
  const Rgb f = (lobe.*evaluate)(wo, out.wi, out.pdf);  // sets the density
  out.weight = f / out.pdf;
  out.specular = false;
  return out.pdf > 0.0;
}

}  // namespace tilecast
