// One sample of the light that reaches a point directly.
#pragma once

#include "integrators/integrator.h"

namespace tilecast {

struct DirectLight {
  Rgb radiance{0.0};  // times |cos| at the light and distance, over the density: what arrives, divided by cos here
  Vec3 direction;     // world space, unit length
  double pdf = 0.0;   // per solid angle; 0: a point light, which no other strategy can find
  Ray shadow;         // ends at the light

  bool arrives() const { return max_component(radiance) > 0.0; }
};

// Light number `light` (points first, then areas), taken with probability `probability`.
DirectLight sample_direct(const Scene& scene, const Surface& surface, size_t light, double probability, Sampler& sampler);

// The density per solid angle with which sample_direct finds a point on area light `area` from a point `distance` away.
inline double area_light_pdf(const Scene& scene, int area, double probability, double distance, double cosine) {
  return probability * distance * distance / (cosine * scene.lights.areas[area].area());
}

}  // namespace tilecast
