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
};

// What a branch adds to the sum where it ends, without what lights do: light(weight, shadow ray, media, light) is called
// for each that may reach the place, and push(branch) for the branches that go on from there, the last of them first.
// resolved(hit) is its surface.
template <bool kPassable, class Resolve, class Push, class Light>
void shade(const Scene& scene, Branch<kPassable>& branch, const Hit& hit, Sampler& sampler, Rgb& sum, Tracing& tracing,
           Resolve&& resolved, Push&& push, Light&& light) {
  if (!hit.found()) {
    sum += branch.weight * branch.media.transmittance(kInfinity) * background(scene, branch.ray.direction);
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
    double through = boundary.real ? (1.0 - opacity) / (boundary.eta * boundary.eta) : 1.0;
    if (through * max_component(branch.weight) >= kFaintest) {
      Branch<kPassable>& straight = push(branch);
      straight.ray.t_min = hit.t;
      straight.weight *= through;
      straight.media.cross(material, hit.entering);
      ++tracing.counts.bounce;
    }
    if (!boundary.real) return;
    branch.weight *= opacity;
  }
  if (built_with("emission") && hit.entering && material.emits()) sum += branch.weight * emission_at(scene, surface);
  if (branch.depth == scene.max_depth) return;

  Basis basis(hit.entering ? surface.normal : -surface.normal);
  Vec3 wo = basis.to_local(wo_world);
  wo.z = std::max(wo.z, 1e-12);
  auto follow = [&](const Vec3& wi, const Rgb& weight) {
    if (max_component(weight) < kFaintest) return;
    Vec3 direction = glm::normalize(basis.to_world(wi));
    Branch<kPassable>& next = push({{surface.spawn(direction), direction}, weight, branch.media, branch.depth + 1});
    if (wi.z < 0.0) next.media.cross(material, hit.entering);
    ++tracing.counts.bounce;
  };
  Bsdf bsdf(scene, surface, boundary);
  if (built_with("shadow_rays") && !bsdf.specular())
    for (size_t number = 0; number < scene.lights.count(); ++number) {
      DirectLight direct = sample_direct(scene, surface, {number, 1.0}, sampler);
      if (!direct.arrives()) continue;
      double pdf;
      Rgb f = bsdf.evaluate(wo, basis.to_local(direct.direction), pdf);
      if (!(max_component(f) > 0.0)) continue;
      light(branch.weight * f * direct.radiance, direct.shadow, branch.media, number);
    }
  Beam beams[kMostBeams];
  for (int i = 0, count = bsdf.beams(wo, beams); i < count; ++i) follow(beams[i].wi, branch.weight * beams[i].weight);
  BsdfSample scattered;
  if (bsdf.sample_glossy(wo, sampler, scattered)) follow(scattered.wi, branch.weight * scattered.weight);
}

}  // namespace tilecast
