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
  Ray ray;        // to a light
  Rgb left{1.0};  // of the light at its end
};
template <>
struct ShadowRay<true> {
  Ray ray;
  Media media;  // in which it starts
  Glass glass = Glass::Passes;
  const Material* end = nullptr;  // the light's, where that refracts
  Rgb left{1.0};
};

// The material of a light that refracts: its surface does not shine where another medium counts. Null: another light.
inline const Material* refracting(const Scene& scene, size_t light) {
  if (!built_with("dielectric") || light < scene.lights.first_area() || light >= scene.lights.first_directional())
    return nullptr;
  const int material = scene.lights.areas[light - scene.lights.first_area()].refracting;
  return material >= 0 ? &scene.materials[material] : nullptr;
}

// What is left of the light at the end of a shadow ray to a light, which starts in these media.
Rgb unshadowed(const Scene& scene, const Ray& ray, const Media& media, Glass glass, size_t light, Tracing& tracing);

// The same of many, of which neighbours should be alike.
void unshadowed(const Scene& scene, std::span<ShadowRay<true>> shadows, Ways& ways, Tracing& tracing);
void unshadowed(const Scene& scene, std::span<ShadowRay<false>> shadows, Ways& ways, Tracing& tracing);

inline Rgb unshadowed(const Scene& scene, const Ray& ray, const NoMedia&, Glass, size_t light, Tracing& tracing) {
  TILECAST_COUNT(shadow);
  ++tracing.counts.shadow;
  return Rgb(occluded(scene, ray, tracing.occluders.of(light)) ? 0.0 : 1.0);
}

}  // namespace tilecast
