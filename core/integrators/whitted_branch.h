// One branch of a ray tree of Whitted's: what is seen where it ends, and what goes on from there.
#pragma once

#include "integrators/direct.h"
#include "integrators/shadow.h"
#include "shading/bsdf.h"

namespace tilecast {

// Branches that would add less than this share of the pixel are not followed (Hall and Greenberg, "A Testbed for
// Realistic Image Synthesis", 1983).
inline constexpr double kFaintest = 1e-5;

template <bool kPassable>
struct Branch {
  Ray ray;
  Rgb weight;
  MediaOf<kPassable> media;
  int depth;
  double scale = 1.0;  // of the weight by refraction, which is not for the share of the pixel to tell
  double pdf = 0.0;    // of a glossy surface's sample that led here; 0: no light could have been sampled instead
};

// What comes from where a branch hits nothing.
template <bool kPassable>
Rgb seen_beyond(const Scene& scene, const Branch<kPassable>& branch) {
  const Vec3& direction = branch.ray.direction;
  const Rgb seen = branch.weight * branch.media.transmittance(kInfinity) * background(scene, direction);
  if (!(built_with("environment") && scene.lights.environment && branch.pdf > 0.0)) return seen;
  return seen * power_heuristic(branch.pdf, environment_pdf(scene.lights, 1.0, direction));
}

// The share that a branch has in what shines at a surface, where lights are sampled as well: all of them, each time.
template <bool kPassable>
double share_of_emission(const Scene& scene, const Branch<kPassable>& branch, const Hit& hit, const Surface& surface) {
  if (!(built_with("area_lights") && branch.pdf > 0.0)) return 1.0;
  const int area = scene.lights.find(hit.primitive);
  if (area < 0) return 1.0;
  const double cosine = std::max(1e-300, -glm::dot(branch.ray.direction, surface.normal));
  return power_heuristic(branch.pdf, area_light_pdf(scene.lights.areas[area], 1.0, branch.ray.origin, hit.t, cosine));
}

// What a branch adds to the sum where it ends, without what lights do: light(weight, shadow ray, media, light, glass) is
// called for each that may reach the place, and push(branch) for the branches that go on from there, the last of them
// first. resolved(hit) is its surface.
//
// A glossy surface finds lights of some extent both by their samples and by its own, which share them by the power
// heuristic. Its own go through glass as light does, so that the others stop there.
template <bool kPassable, class Resolve, class Push, class Light>
void shade(const Scene& scene, Branch<kPassable>& branch, const Hit& hit, Sampler& sampler, Rgb& sum, Tracing& tracing,
           Resolve&& resolved, Push&& push, Light&& light) {
  if (!hit.found()) {
    sum += seen_beyond(scene, branch);
    return;
  }
  Surface surface = resolved(hit);
  const Material& material = *surface.material;
  Vec3 wo_world = -branch.ray.direction;
  branch.weight *= branch.media.transmittance(hit.t - branch.ray.t_min);
  Boundary boundary;
  if (kPassable && passable(material)) {
    boundary = branch.media.at(material, hit.entering);
    const double opacity = opacity_at(scene, surface);
    const double passing = boundary.real ? 1.0 - opacity : 1.0, eta2 = boundary.real ? boundary.eta * boundary.eta : 1.0;
    if (passing * max_component(branch.weight) * branch.scale >= kFaintest) {
      Branch<kPassable>& straight = push(branch);
      straight.ray.t_min = hit.t;
      straight.weight *= passing / eta2;
      straight.scale *= eta2;
      straight.media.cross(material, hit.entering);
      ++tracing.counts.bounce;
    }
    if (!boundary.real) return;
    branch.weight *= opacity;
  }
  if (built_with("emission") && hit.entering && material.emits())
    sum += branch.weight * emission_at(scene, surface) * share_of_emission(scene, branch, hit, surface);
  if (branch.depth == scene.max_depth) return;

  Basis basis(hit.entering ? surface.normal : -surface.normal);
  Vec3 wo = basis.to_local(wo_world);
  wo.z = std::max(wo.z, 1e-12);
  auto follow = [&](const Vec3& wi, const Rgb& weight, double pdf) {
    const bool through = kPassable && wi.z < 0.0;
    const double scale = through ? branch.scale * (boundary.eta * boundary.eta) : branch.scale;
    if (max_component(weight) * scale < kFaintest) return;
    Vec3 direction = glm::normalize(basis.to_world(wi));
    Branch<kPassable>& next =
        push({{surface.spawn(direction), direction}, weight, branch.media, branch.depth + 1, scale, pdf});
    if (through) next.media.cross(material, hit.entering);
    ++tracing.counts.bounce;
  };
  Bsdf bsdf(scene, surface, boundary);
  if (built_with("shadow_rays") && !bsdf.specular())
    for (size_t number = 0; number < scene.lights.count(); ++number) {
      DirectLight direct = sample_direct(scene, surface, {number, 1.0}, sampler);
      if (!direct.arrives()) continue;
      const Vec3 wi = basis.to_local(direct.direction);
      const SplitBsdf f = bsdf.split(wo, wi);
      auto reflect = [&](const Rgb& part, Glass glass) {
        if (!(max_component(part) > 0.0)) return;
        const Rgb weight = branch.weight * part * direct.radiance;
        if (kPassable && wi.z < 0.0) {
          MediaOf<kPassable> behind = branch.media;
          behind.cross(material, hit.entering);
          light(weight, direct.shadow, behind, number, glass);
        } else {
          light(weight, direct.shadow, branch.media, number, glass);
        }
      };
      const double share = direct.pdf > 0.0 ? power_heuristic(direct.pdf, f.pdf) : 1.0;
      if (kPassable && scene.dielectrics && direct.pdf > 0.0) {
        reflect(f.other, Glass::Passes);
        reflect(share * f.glossy, Glass::Stops);
      } else {
        reflect(f.other + share * f.glossy, Glass::Passes);
      }
    }
  Beam beams[kMostBeams];
  for (int i = 0, count = bsdf.beams(wo, beams); i < count; ++i) follow(beams[i].wi, branch.weight * beams[i].weight, 0.0);
  BsdfSample scattered;
  if (bsdf.sample_glossy(wo, sampler, scattered)) follow(scattered.wi, branch.weight * scattered.weight, scattered.pdf);
}

}  // namespace tilecast
