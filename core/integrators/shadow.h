// Light along shadow rays, which not all surfaces stop.
#pragma once

#include <span>

#include "base/counters.h"
#include "integrators/integrator.h"

namespace tilecast {

enum class Glass : uint8_t {
  Stops,  // paths find what comes through it by refraction
  Passes  // unbent, weakened at its surfaces and inside
};

template <bool kPassable>
struct ShadowRay {
  Ray ray;                    // to a light
  MediaOf<kPassable> media;   // in which it starts
  Rgb left{1.0};              // of the light at its end
};

// What is left of the light at the end of a shadow ray to a light, which starts in these media.
Rgb unshadowed(const Scene& scene, const Ray& ray, const Media& media, Glass glass, size_t light, Tracing& tracing);

// The same of many, of which neighbours should be alike, where Glass::Passes.
void unshadowed(const Scene& scene, std::span<ShadowRay<true>> shadows, Glass glass, Ways& ways, Tracing& tracing);
void unshadowed(const Scene& scene, std::span<ShadowRay<false>> shadows, Glass glass, Ways& ways, Tracing& tracing);

inline Rgb unshadowed(const Scene& scene, const Ray& ray, const NoMedia&, Glass, size_t light, Tracing& tracing) {
  TILECAST_COUNT(shadow);
  ++tracing.counts.shadow;
  return Rgb(occluded(scene, ray, tracing.occluders.of(light)) ? 0.0 : 1.0);
}

}  // namespace tilecast
