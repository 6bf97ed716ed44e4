// Light along shadow rays that not all surfaces stop.
#pragma once

#include "integrators/integrator.h"

namespace tilecast {

enum class Glass : uint8_t {
  Stops,  // paths find what comes through it by refraction
  Passes  // unbent, weakened at its surfaces and inside
};

// What is left of the light at the end of a shadow ray (t = 1) that starts in these media.
Rgb shadow_transmittance(const Scene& scene, Ray ray, Media media, Glass glass, Tracing& tracing);

}  // namespace tilecast
