#include "integrators/direct.h"
#include "integrators/roulette.h"
#include "integrators/shadow.h"
#include "optics/spectrum.h"
#include "shading/bsdf.h"

namespace tilecast {
namespace {

// What the lights send to the surface and on to wo, by one of them. media: on the side of wo.
template <class SomeMedia>
Rgb next_event(const Scene& scene, const Surface& surface, bool entering, const LitPlace& place, const Basis& basis,
               const Vec3& wo, const Bsdf& bsdf, const SomeMedia& media, Sampler& sampler, Tracing& tracing) {
  LightChoice choice{0, 1.0};
  if (scene.lights.count() > 1) choice = scene.lights.choose(sampler.next1(), place);
  if (!(choice.probability > 0.0)) return Rgb(0.0);
  DirectLight direct = sample_direct(scene, surface, choice, sampler);
  if (!direct.arrives()) return Rgb(0.0);
  Vec3 wi = basis.to_local(direct.direction);
  double bsdf_pdf;
  Rgb f = bsdf.evaluate(wo, wi, bsdf_pdf);
  if (!(max_component(f) > 0.0)) return Rgb(0.0);
  auto unshadowed_in = [&](const SomeMedia& here) {
    return unshadowed(scene, direct.shadow, here, Glass::Stops, choice.light, tracing);
  };
  Rgb left;
  if (built_with("dielectric") && wi.z < 0.0) {
    SomeMedia behind = media;
    behind.cross(*surface.material, entering);
    left = unshadowed_in(behind);
  } else {
    left = unshadowed_in(media);
  }
  return f * direct.radiance * left * (direct.pdf > 0.0 ? power_heuristic(direct.pdf, bsdf_pdf) : 1.0);
}

template <bool kPassable>
Rgb trace(const Scene& scene, Ray ray, MediaOf<kPassable> media, Sampler& sampler, Tracing& tracing, Seen seen,
          const PathState& state = {}) {
  const int max_depth = scene.integrator == Integrator::Direct ? std::min(2, scene.max_depth) : scene.max_depth;
  const bool sample_lights = built_with("shadow_rays") && scene.next_event && scene.lights.count() > 0;
  Rgb sum = state.sum, throughput = state.throughput;
  double scale = state.scale, bsdf_pdf = state.bsdf_pdf;
  LitPlace from = state.from;
  auto chosen = [&](size_t light) { return scene.lights.probability(light, from); };
  for (int depth = state.depth;; ++depth) {
    Hit hit;
    Surface surface;
    Boundary boundary;
    for (;;) {  // to the first surface that the light does not go straight through
      hit = closest(scene, ray);
      if (!hit.found()) {
        const bool sampled = built_with("environment") && sample_lights && bsdf_pdf > 0.0 && scene.lights.environment;
        double weight = 1.0;
        if (sampled) {
          const double probability = chosen(scene.lights.environment_number());
          weight = power_heuristic(bsdf_pdf, environment_pdf(scene.lights, probability, ray.direction));
        }
        return sum + throughput * media.transmittance(kInfinity) * background(scene, ray.direction) * weight;
      }
      surface = resolve(scene, ray, hit);
      throughput *= media.transmittance(hit.t - ray.t_min);
      if (!(kPassable && passable(*surface.material))) break;
      if constexpr (kPassable && built_with("dispersion"))
        if (scene.disperses && media.splits(*surface.material)) {
          const Wavelength one = sample_wavelength(sampler.next1());
          media.split(one.shift);
          throughput *= one.weight;
        }
      boundary = media.at(*surface.material, hit.entering);
      if (boundary.real) {
        double opacity = opacity_at(scene, surface);
        if (opacity == 1.0 || sampler.next1() < opacity) break;
        throughput /= boundary.eta * boundary.eta;
        scale *= boundary.eta * boundary.eta;
      }
      media.cross(*surface.material, hit.entering);
      ray.t_min = hit.t;
      ++tracing.counts.bounce;
    }
    const Material& material = *surface.material;
    Vec3 wo_world = -ray.direction;
    double distance = hit.t;

    const bool apart =
        seen == Seen::Apart && depth == 1 && ray.t_min == 0.0 && !(kPassable && passable(material));
    if (built_with("emission") && hit.entering && material.emits() && !apart) {
      double weight = 1.0;
      int area = built_with("area_lights") && sample_lights && bsdf_pdf > 0.0 ? scene.lights.find(hit.primitive) : -1;
      if (area >= 0) {
        double cosine = std::max(1e-300, glm::dot(wo_world, surface.normal));
        const double probability = chosen(scene.lights.first_area() + area);
        weight = power_heuristic(bsdf_pdf, area_light_pdf(scene.lights.areas[area], probability, from.point, distance, cosine));
      }
      sum += throughput * emission_at(scene, surface) * weight;
    }
    if (depth == max_depth) break;

    Basis basis(hit.entering ? surface.normal : -surface.normal);
    Vec3 wo = basis.to_local(wo_world);
    wo.z = std::max(wo.z, 1e-12);
    Bsdf bsdf(scene, surface, boundary);
    if (sample_lights && !bsdf.specular()) {
      // Lights behind the surface count as well where any may come through.
      from = {surface.point, kPassable && refracts(material) ? Vec3(0.0) : basis.z};
      sum += throughput * next_event(scene, surface, hit.entering, from, basis, wo, bsdf, media, sampler, tracing);
    }

    BsdfSample scattered;
    if (!bsdf.sample(wo, sampler, scattered)) break;
    throughput *= scattered.weight;
    bsdf_pdf = scattered.specular ? 0.0 : scattered.pdf;
    if (kPassable && built_with("dielectric") && scattered.wi.z < 0.0) {
      scale *= boundary.eta * boundary.eta;
      media.cross(material, hit.entering);
    }
    double strength = max_component(throughput) * scale;
    if (!(strength > 0.0)) break;
    if (depth >= kRouletteDepth && scene.roulette) {
      double survival = std::min(1.0, strength);
      if (sampler.next1() >= survival) break;
      throughput /= survival;
    }
    Vec3 direction = glm::normalize(basis.to_world(scattered.wi));
    ray = {surface.spawn(direction), direction};
    ++tracing.counts.bounce;
  }
  return sum;
}

}  // namespace

Rgb seen_emission(const Scene& scene, const Ray& ray, Tracing& tracing) {
  ++tracing.counts.camera;
  const Hit hit = closest(scene, ray);
  if (!hit.found() || !hit.entering) return Rgb(0.0);
  const Surface surface = resolve(scene, ray, hit);
  if (!surface.material->emits() || passable(*surface.material)) return Rgb(0.0);
  return emission_at(scene, surface);
}

Rgb trace_path(const Scene& scene, const Ray& ray, const Media& media, Sampler& sampler, Tracing& tracing, Seen seen) {
  ++tracing.counts.camera;
  if (passable(scene)) return trace<true>(scene, ray, media, sampler, tracing, seen);
  return trace<false>(scene, ray, {}, sampler, tracing, seen);
}

Rgb continue_path(const Scene& scene, const Ray& ray, const Media& media, Sampler& sampler, Tracing& tracing, Seen seen,
                  const PathState& state) {
  return trace<true>(scene, ray, media, sampler, tracing, seen, state);
}

}  // namespace tilecast
