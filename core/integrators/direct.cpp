#include "integrators/direct.h"

#include "integrators/ball_light.h"

namespace tilecast {
namespace {

// A density that can be divided by, and what is divided by it as well; else 0.
double usable(double pdf) { return pdf > 1e-150 && pdf < 1e150 ? pdf : 0.0; }

// Towards a place, off the surface by its error bound; t = 1 is the place.
void aim(const Surface& surface, const Vec3& light, DirectLight& out) {
  Vec3 start = surface.spawn(light - surface.point);
  out.shadow = {start, light - start, 0.0, 1.0};
  out.distance = glm::length(out.shadow.direction);
}

// The same for what is infinitely far away.
void aim_far(const Surface& surface, DirectLight& out) {
  out.shadow = {surface.spawn(out.direction), out.direction, 0.0, kInfinity};
}

DirectLight from_place(const Surface& surface, const Vec3& position, const Rgb& intensity, double probability) {
  DirectLight out;
  Vec3 towards = position - surface.point;
  double distance2 = glm::dot(towards, towards);
  if (!(distance2 > 0.0)) return out;
  out.direction = towards / std::sqrt(distance2);
  out.radiance = intensity / (distance2 * probability);
  if (!is_finite(out.radiance)) return {};  // the surface goes through the light
  aim(surface, position, out);
  return out;
}

DirectLight from_area(const Surface& surface, const AreaLight& area, double probability, Sampler& sampler) {
  DirectLight out;
  LightSample at;
  double pdf = 0.0;
  if (area.shape == AreaLight::Shape::Ball) {
    const Vec3& centre = area.pieces[0].origin;
    const double radius = area.radius();
    const BallCone cone = cone_of(centre - surface.point, radius);
    pdf = usable(cone.pdf() * probability);
    if (pdf == 0.0) return out;
    at.normal = sample_normal(cone, centre - surface.point, sampler.next2());
    at.point = centre + radius * at.normal;
    at.error = 32 * kUnitRoundoff * (max_abs(centre) + radius);
  } else {
    const double piece = area.pieces.size() > 1 ? sampler.next1() : 0.0;
    at = sample(area, piece, sampler.next2());
  }
  Vec3 towards = at.point - surface.point;
  double distance2 = glm::dot(towards, towards);
  if (!(distance2 > 0.0)) return out;
  double distance = std::sqrt(distance2);
  out.direction = towards / distance;
  double cosine = -glm::dot(out.direction, at.normal);
  if (cosine <= 0.0) return out;  // its back
  if (area.shape != AreaLight::Shape::Ball) pdf = usable(probability * distance2 / (cosine * area.area()));
  if (pdf == 0.0) return out;
  out.pdf = pdf;
  out.radiance = area.radiance / pdf;
  aim(surface, at.point + at.error * at.normal, out);
  return out;
}

}  // namespace

DirectLight sample_direct(const Scene& scene, const Surface& surface, const LightChoice& choice, Sampler& sampler) {
  const Lights& lights = scene.lights;
  const size_t light = choice.light;
  const double probability = choice.probability;
  if (built_with("point_lights") && light < lights.first_spot())
    return from_place(surface, lights.points[light].position, lights.points[light].intensity, probability);
  if (built_with("spot_lights") && light < lights.first_area()) {
    const SpotLight& spot = lights.spots[light - lights.first_spot()];
    DirectLight out = from_place(surface, spot.position, spot.intensity, probability);
    if (out.arrives()) out.radiance *= spot.falloff(-glm::dot(out.direction, spot.direction));
    return out;
  }
  if (built_with("area_lights") && light < lights.first_directional())
    return from_area(surface, lights.areas[light - lights.first_area()], probability, sampler);
  DirectLight out;
  if (built_with("directional_lights") && light < lights.environment_number()) {
    const DirectionalLight& sun = lights.directionals[light - lights.first_directional()];
    out.direction = -sun.direction;
    out.radiance = sun.irradiance / probability;
  } else if (built_with("environment")) {
    const Environment::Sample found = lights.environment->sample(sampler.next2());
    out.pdf = usable(found.pdf * probability);
    if (out.pdf == 0.0) return out;
    out.direction = found.direction;
    out.radiance = lights.environment->radiance(found.direction) / out.pdf;
  }
  aim_far(surface, out);
  return out;
}

double area_light_pdf(const AreaLight& light, double probability, const Vec3& from, double distance, double cosine) {
  if (light.shape == AreaLight::Shape::Ball)
    return usable(probability * cone_of(light.pieces[0].origin - from, light.radius()).pdf());
  return usable(probability * distance * distance / (cosine * light.area()));
}

double environment_pdf(const Lights& lights, double probability, const Vec3& direction) {
  return usable(probability * lights.environment->pdf(direction));
}

}  // namespace tilecast
