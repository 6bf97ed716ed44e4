// A direction into which light is scattered, in the local frame whose z axis is the normal on the viewer's side.
#pragma once

#include "base/sampler.h"

namespace tilecast {

struct BsdfSample {
  Vec3 wi;            // wi.z < 0: through the surface
  Rgb weight;         // f |cos| / density
  double pdf = 0.0;   // per solid angle; not used where `specular`
  bool specular = false;
};

}  // namespace tilecast
