#include "integrators/direct.h"

namespace tilecast {
namespace {

// From the surface to the light, off both by their error bounds; t = 1 is the light.
Ray shadow_ray(const Surface& surface, const Vec3& light) {
  Vec3 start = surface.spawn(light - surface.point);
  return {start, light - start, 0.0, 1.0};
}

}  // namespace

DirectLight sample_direct(const Scene& scene, const Surface& surface, size_t light, double probability,
                          Sampler& sampler) {
  DirectLight out;
  if (light < scene.lights.points.size()) {
    const PointLight& point = scene.lights.points[light];
    Vec3 towards = point.position - surface.point;
    double distance2 = glm::dot(towards, towards);
    if (!(distance2 > 0.0)) return out;
    out.direction = towards / std::sqrt(distance2);
    out.radiance = point.intensity / (distance2 * probability);
    out.shadow = shadow_ray(surface, point.position);
    return out;
  }
  size_t index = light - scene.lights.points.size();
  const AreaLight& area = scene.lights.areas[index];
  double piece = area.pieces.size() > 1 ? sampler.next1() : 0.0;
  LightSample point = sample(area, piece, sampler.next2());
  Vec3 towards = point.point - surface.point;
  double distance2 = glm::dot(towards, towards);
  if (!(distance2 > 0.0)) return out;
  double distance = std::sqrt(distance2);
  out.direction = towards / distance;
  double cosine = -glm::dot(out.direction, point.normal);
  if (cosine <= 0.0) return out;  // its back
  out.pdf = area_light_pdf(scene, static_cast<int>(index), probability, distance, cosine);
  out.radiance = point.radiance / out.pdf;
  out.shadow = shadow_ray(surface, point.point + point.error * point.normal);
  return out;
}

}  // namespace tilecast
