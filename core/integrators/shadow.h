// Light along shadow rays that not all surfaces stop.
#pragma once

#include "integrators/integrator.h"

namespace tilecast {

enum class Glass : uint8_t {
  Stops,  // paths find what comes through it by refraction
  Passes  // unbent, weakened at its surfaces and inside
};

// What is left of the light at the end of a shadow ray to a light, which starts in these media.
Rgb unshadowed(const Scene& scene, const Ray& ray, const Media& media, Glass glass, size_t light, Tracing& tracing);

}  // namespace tilecast
