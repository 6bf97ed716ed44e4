#include "integrators/shadow.h"

#include <numeric>

#include "optics/fresnel.h"
#include "scene/packet.h"
#include "shading/textured.h"

namespace tilecast {
namespace {

// Goes on behind what the ray hits, whose surface resolved() gives; false where it ends, at the light or at what lets nothing pass.
template <class Resolve>
bool pass(const Scene& scene, ShadowRay<true>& shadow, const Hit& hit, Resolve&& resolved) {
  Ray& ray = shadow.ray;
  Rgb& left = shadow.left;
  const double length = glm::length(ray.direction);
  left *= shadow.media.transmittance(length * (std::min(hit.t, ray.t_max) - ray.t_min));
  if (!hit.found()) {
    if (shadow.end && !shadow.media.at(*shadow.end, true).real) left = Rgb(0.0);
    return false;
  }
  Surface surface = resolved(ray, hit);
  const Material& material = *surface.material;
  if (!passable(material)) {
    left = Rgb(0.0);
    return false;
  }
  Boundary boundary = shadow.media.at(material, hit.entering);
  if (boundary.real) {
    const double opacity = opacity_at(scene, surface);
    const double eta = boundary.eta;
    if (shadow.glass == Glass::Passes && material.kind == MaterialKind::Dielectric) {
      // Unbent, the ray has one angle on both sides: that of the thinner medium, so that no reflection is total.
      double cosine = std::min(1.0, std::fabs(glm::dot(surface.normal, ray.direction)) / length);
      left *= (1.0 - opacity) + opacity * (1.0 - fresnel_dielectric(cosine, std::max(eta, 1.0 / eta)).reflectance);
    } else {
      left *= (1.0 - opacity) / (eta * eta);
    }
  }
  shadow.media.cross(material, hit.entering);
  ray.t_min = hit.t;
  return max_component(left) > 0.0;
}

// Through all surfaces that let light pass.
Rgb shadow_transmittance(const Scene& scene, ShadowRay<true> shadow, Tracing& tracing) {
  TILECAST_COUNT(shadow);
  do ++tracing.counts.shadow;
  while (pass(scene, shadow, closest(scene, shadow.ray),
              [&](const Ray& at, const Hit& hit) { return resolve(scene, at, hit); }));
  return shadow.left;
}

}  // namespace

Rgb unshadowed(const Scene& scene, const Ray& ray, const Media& media, Glass glass, size_t light, Tracing& tracing) {
  // Inside of a medium there may be surfaces of others that do not count there.
  const bool glass_in_the_way = glass == Glass::Passes ? scene.dielectrics : media.current() != nullptr;
  if ((built_with("opacity") && scene.see_through) || (built_with("dielectric") && glass_in_the_way))
    return shadow_transmittance(scene, {ray, media, glass, refracting(scene, light)}, tracing);
  return unshadowed(scene, ray, NoMedia{}, glass, light, tracing);
}

void unshadowed(const Scene& scene, std::span<ShadowRay<true>> shadows, Ways& ways, Tracing& tracing) {
  auto resolved = [&](const Ray& ray, const Hit& hit) { return ways.resolve(ways.to(hit.primitive), ray, hit); };
  std::vector<uint32_t> going(shadows.size());
  std::iota(going.begin(), going.end(), 0u);
  std::vector<Ray> rays;
  std::vector<Hit> hits;
  while (!going.empty()) {
    tracing.counts.shadow += going.size();
    rays.clear();
    for (uint32_t i : going) rays.push_back(shadows[i].ray);
    hits.resize(rays.size());
    closest(scene, rays, hits.data());
    size_t at = 0;
    std::erase_if(going, [&](uint32_t i) { return !pass(scene, shadows[i], hits[at++], resolved); });
  }
}

void unshadowed(const Scene& scene, std::span<ShadowRay<false>> shadows, Ways&, Tracing& tracing) {
  tracing.counts.shadow += shadows.size();
  std::vector<Ray> rays;
  for (const ShadowRay<false>& shadow : shadows) rays.push_back(shadow.ray);
  const std::unique_ptr<bool[]> found = std::make_unique<bool[]>(rays.size());
  occluded(scene, rays, found.get());
  for (size_t i = 0; i < rays.size(); ++i) shadows[i].left = Rgb(found[i] ? 0.0 : 1.0);
}

}  // namespace tilecast
