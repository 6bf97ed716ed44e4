#include "base/counters.h"
#include "integrators/direct.h"
#include "shading/bsdf.h"

namespace tilecast {
namespace {

// Branches that would add less than this share of the pixel are not followed (Hall and Greenberg, "A Testbed for
// Realistic Image Synthesis", 1983).
constexpr double kFaintest = 1e-5;

// What is left of light that passes along the shadow ray: straight through dielectrics, stopped by all else.
Rgb shadow_transmittance(const Scene& scene, Ray ray, Media media, Tracing& tracing) {
  TILECAST_COUNT(shadow);
  Rgb left(1.0);
  const bool endless = ray.t_max == kInfinity;
  double length = glm::length(ray.direction);
  for (int i = 0; i < scene.max_depth; ++i) {
    ++tracing.counts.shadow;
    Hit hit = closest(scene, ray);
    if (!hit.found()) return left * media.transmittance(endless ? kInfinity : length);
    Surface surface = resolve(scene, ray, hit);
    const Material& material = *surface.material;
    if (material.kind != MaterialKind::Dielectric) return Rgb(0.0);
    left *= media.transmittance(length * hit.t);
    double cosine = std::min(1.0, std::fabs(glm::dot(surface.normal, ray.direction)) / length);
    // Unbent, the ray has one angle on both sides: that of the thinner medium, so that nothing is totally reflected.
    double eta = media.eta(material, hit.entering);
    left *= 1.0 - fresnel_dielectric(cosine, std::max(eta, 1.0 / eta)).reflectance;
    if (hit.entering)
      media.enter(&material);
    else
      media.leave(&material);
    if (!(max_component(left) > 0.0)) break;
    Vec3 end = ray.origin + ray.direction;
    Vec3 start = surface.spawn(ray.direction);
    if (endless) {
      ray.origin = start;
      continue;
    }
    if (glm::dot(end - start, ray.direction) <= 0.0) return left;
    ray = {start, end - start, 0.0, 1.0};
    length = glm::length(ray.direction);
  }
  return Rgb(0.0);
}

}  // namespace

Rgb trace_whitted(const Scene& scene, const Ray& camera_ray, const Media& camera_media, Sampler& sampler,
                  Tracing& tracing) {
  struct Branch {
    Ray ray;
    Rgb weight;
    Media media;
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
    branch.weight *= branch.media.transmittance(hit.t);
    if (hit.entering && material.emits()) sum += branch.weight * material.emission;
    if (branch.depth == scene.max_depth) continue;

    Basis basis(hit.entering ? surface.normal : -surface.normal);
    Vec3 wo = basis.to_local(wo_world);
    wo.z = std::max(wo.z, 1e-12);
    auto follow = [&](const Vec3& wi, const Rgb& weight, const Media& media) {
      if (max_component(weight) < kFaintest) return;
      Vec3 direction = glm::normalize(basis.to_world(wi));
      pending.push_back({{surface.spawn(direction), direction}, weight, media, branch.depth + 1});
      ++tracing.counts.bounce;
    };
    if (material.kind == MaterialKind::Dielectric) {
      double eta = branch.media.eta(material, hit.entering);
      Fresnel fresnel = fresnel_dielectric(wo.z, eta);
      follow(reflect(wo), branch.weight * fresnel.reflectance, branch.media);
      if (!fresnel.total) {
        Media behind = branch.media;
        if (hit.entering)
          behind.enter(&material);
        else
          behind.leave(&material);
        follow(refract(wo, eta, fresnel.cos_transmitted), branch.weight * ((1.0 - fresnel.reflectance) / (eta * eta)),
               behind);
      }
      continue;
    }
    Bsdf bsdf(material, reflectance_at(scene, surface), 1.0);
    if (!bsdf.specular())
      for (size_t light = 0; light < scene.lights.count(); ++light) {
        DirectLight direct = sample_direct(scene, surface, {light, 1.0}, sampler);
        if (!direct.arrives()) continue;
        double pdf;
        Rgb f = bsdf.evaluate(wo, basis.to_local(direct.direction), pdf);
        if (!(max_component(f) > 0.0)) continue;
        Rgb left(1.0);
        if (scene.dielectrics) {
          left = shadow_transmittance(scene, direct.shadow, branch.media, tracing);
        } else {
          ++tracing.counts.shadow;
          left = Rgb(occluded(scene, direct.shadow, tracing.occluders.of(light)) ? 0.0 : 1.0);
        }
        sum += branch.weight * f * direct.radiance * left;
      }
    BsdfSample scattered;
    if (material.kind != MaterialKind::Diffuse && bsdf.sample(wo, sampler, scattered))
      follow(scattered.wi, branch.weight * scattered.weight, branch.media);
  }
  return sum;
}

}  // namespace tilecast
