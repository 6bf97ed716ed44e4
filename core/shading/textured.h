// What a material says at a point of a surface: its parameters, or its textures there.
#pragma once

#include "base/counters.h"
#include "scene/surface.h"

namespace tilecast {

inline Rgb lookup(const Scene& scene, int texture, const Surface& surface) {
  TILECAST_COUNT(texture);
  return at(scene.textures[texture], surface.place);
}

inline Rgb reflectance_at(const Scene& scene, const Surface& surface, const Material& material) {
  return material.texture < 0 ? material.reflectance : lookup(scene, material.texture, surface);
}
inline double roughness_at(const Scene& scene, const Surface& surface, const Material& material) {
  return material.roughness_texture < 0 ? material.roughness : lookup(scene, material.roughness_texture, surface).x;
}
inline double opacity_at(const Scene& scene, const Surface& surface) {
  const Material& material = *surface.material;
  return material.opacity_texture < 0 ? material.opacity : lookup(scene, material.opacity_texture, surface).x;
}
inline Rgb emission_at(const Scene& scene, const Surface& surface) {
  const Material& material = *surface.material;
  return material.emission_texture < 0 ? material.emission : lookup(scene, material.emission_texture, surface);
}

}  // namespace tilecast
