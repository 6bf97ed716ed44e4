#include "integrators/direct.h"
#include "integrators/shadow.h"
#include "shading/bsdf.h"

namespace tilecast {
namespace {

// Branches that would add less than this share of the pixel are not followed (Hall and Greenberg, "A Testbed for
// Realistic Image Synthesis", 1983).
constexpr double kFaintest = 1e-5;

template <bool kPassable>
Rgb trace(const Scene& scene, const Ray& camera_ray, const MediaOf<kPassable>& camera_media, Sampler& sampler,
          Tracing& tracing) {
  struct Branch {
    Ray ray;
    Rgb weight;
    MediaOf<kPassable> media;
    int depth;
  };
  thread_local std::vector<Branch> kept;  // from ray to ray, so that tracing does not allocate
  std::vector<Branch>& pending = kept;
  pending.clear();
  pending.push_back({camera_ray, Rgb(1.0), camera_media, 1});
  ++tracing.counts.camera;
  Rgb sum(0.0);
  while (!pending.empty()) {
    Branch branch = pending.back();
    pending.pop_back();
    Hit hit = closest(scene, branch.ray);
    if (!hit.found()) {
      sum += branch.weight * branch.media.transmittance(kInfinity) * background(scene, branch.ray.direction);
      continue;
    }
    Surface surface = resolve(scene, branch.ray, hit);
    const Material& material = *surface.material;
    Vec3 wo_world = -branch.ray.direction;
    branch.weight *= branch.media.transmittance(hit.t - branch.ray.t_min);
    Boundary boundary;
    if (kPassable && passable(material)) {
      boundary = branch.media.at(material, hit.entering);
      const double opacity = opacity_at(scene, surface);
      double through = boundary.real ? (1.0 - opacity) / (boundary.eta * boundary.eta) : 1.0;
      if (through * max_component(branch.weight) >= kFaintest) {
        pending.push_back(branch);
        Branch& straight = pending.back();
        straight.ray.t_min = hit.t;
        straight.weight *= through;
        straight.media.cross(material, hit.entering);
        ++tracing.counts.bounce;
      }
      if (!boundary.real) continue;
      branch.weight *= opacity;
    }
    if (built_with("emission") && hit.entering && material.emits()) sum += branch.weight * emission_at(scene, surface);
    if (branch.depth == scene.max_depth) continue;

    Basis basis(hit.entering ? surface.normal : -surface.normal);
    Vec3 wo = basis.to_local(wo_world);
    wo.z = std::max(wo.z, 1e-12);
    auto follow = [&](const Vec3& wi, const Rgb& weight) {
      if (max_component(weight) < kFaintest) return;
      Vec3 direction = glm::normalize(basis.to_world(wi));
      pending.push_back({{surface.spawn(direction), direction}, weight, branch.media, branch.depth + 1});
      if (wi.z < 0.0) pending.back().media.cross(material, hit.entering);
      ++tracing.counts.bounce;
    };
    Bsdf bsdf(scene, surface, boundary);
    if (built_with("shadow_rays") && !bsdf.specular())
      for (size_t light = 0; light < scene.lights.count(); ++light) {
        DirectLight direct = sample_direct(scene, surface, {light, 1.0}, sampler);
        if (!direct.arrives()) continue;
        double pdf;
        Rgb f = bsdf.evaluate(wo, basis.to_local(direct.direction), pdf);
        if (!(max_component(f) > 0.0)) continue;
        sum += branch.weight * f * direct.radiance *
               unshadowed(scene, direct.shadow, branch.media, Glass::Passes, light, tracing);
      }
    Beam beams[kMostBeams];
    for (int i = 0, count = bsdf.beams(wo, beams); i < count; ++i) follow(beams[i].wi, branch.weight * beams[i].weight);
    BsdfSample scattered;
    if (bsdf.sample_glossy(wo, sampler, scattered)) follow(scattered.wi, branch.weight * scattered.weight);
  }
  return sum;
}

}  // namespace

Rgb trace_whitted(const Scene& scene, const Ray& ray, const Media& media, Sampler& sampler, Tracing& tracing) {
  if (passable(scene)) return trace<true>(scene, ray, media, sampler, tracing);
  return trace<false>(scene, ray, {}, sampler, tracing);
}

}  // namespace tilecast
