// What a material says at a point of a surface: its parameters, or its textures there.
#pragma once

#include "base/built.h"
#include "base/counters.h"
#include "scene/surface.h"

namespace tilecast {

// Whether a number of a texture is one, and not -1 for none.
inline bool is_texture(int texture) { return built_with("texture") && texture >= 0; }

inline Rgb lookup(const Scene& scene, int texture, const Surface& surface) {
  TILECAST_COUNT(texture);
  return at(scene.textures[texture], surface.place);
}

inline Rgb reflectance_at(const Scene& scene, const Surface& surface, const Material& material) {
  return is_texture(material.texture) ? lookup(scene, material.texture, surface) : material.reflectance;
}
inline double roughness_at(const Scene& scene, const Surface& surface, const Material& material) {
  return is_texture(material.roughness_texture) ? lookup(scene, material.roughness_texture, surface).x
                                                : material.roughness;
}
inline double opacity_at(const Scene& scene, const Surface& surface) {
  const Material& material = *surface.material;
  if (!built_with("opacity")) return 1.0;
  return is_texture(material.opacity_texture) ? lookup(scene, material.opacity_texture, surface).x : material.opacity;
}
inline Rgb emission_at(const Scene& scene, const Surface& surface) {
  const Material& material = *surface.material;
  return is_texture(material.emission_texture) ? lookup(scene, material.emission_texture, surface) : material.emission;
}

}  // namespace tilecast
