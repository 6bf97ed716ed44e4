#include "integrators/shadow.h"

#include "optics/fresnel.h"
#include "shading/textured.h"

namespace tilecast {
namespace {

// Through all surfaces that let light pass.
Rgb shadow_transmittance(const Scene& scene, Ray ray, Media media, Glass glass, Tracing& tracing) {
  Rgb left(1.0);
  const double length = glm::length(ray.direction);
  TILECAST_COUNT(shadow);
  while (max_component(left) > 0.0) {
    ++tracing.counts.shadow;
    Hit hit = closest(scene, ray);
    left *= media.transmittance(length * (std::min(hit.t, ray.t_max) - ray.t_min));
    if (!hit.found()) return left;
    Surface surface = resolve(scene, ray, hit);
    const Material& material = *surface.material;
    if (!passable(material)) return Rgb(0.0);
    Boundary boundary = media.at(material, hit.entering);
    if (boundary.real) {
      const double opacity = opacity_at(scene, surface);
      double eta = boundary.eta, through = (1.0 - opacity) / (eta * eta);
      if (glass == Glass::Passes && material.kind == MaterialKind::Dielectric) {
        // Unbent, the ray has one angle on both sides: that of the thinner medium, so that no reflection is total.
        double cosine = std::min(1.0, std::fabs(glm::dot(surface.normal, ray.direction)) / length);
        left *= through + opacity * (1.0 - fresnel_dielectric(cosine, std::max(eta, 1.0 / eta)).reflectance);
      } else {
        left *= through;
      }
    }
    media.cross(material, hit.entering);
    ray.t_min = hit.t;
  }
  return left;
}

}  // namespace

Rgb unshadowed(const Scene& scene, const Ray& ray, const Media& media, Glass glass, size_t light, Tracing& tracing) {
  // Inside of a medium there may be surfaces of others that do not count there.
  const bool glass_in_the_way = glass == Glass::Passes ? scene.dielectrics : media.current() != nullptr;
  if ((built_with("opacity") && scene.see_through) || (built_with("dielectric") && glass_in_the_way))
    return shadow_transmittance(scene, ray, media, glass, tracing);
  return unshadowed(scene, ray, NoMedia{}, glass, light, tracing);
}

}  // namespace tilecast
