// Views: what a camera ray meets, as a colour.
//
//   normals     0.5 + 0.5 n of the geometric normal: outward, unit length, world space
//   depth       metres along the ray, in all three channels
//   primitives  a colour for each triangle and each face of a solid, instances apart
//   instances   a colour for each placed object; a CSG of closed objects is one
//   facing      front sides blue, back sides red, fainter the more they are seen from the side
//   cost        steps through the accelerator and primitives tested, in all three channels
//
// Where nothing is hit, all but the cost are black.
#include "integrators/integrator.h"
#include "scene/descend.h"

namespace tilecast {
namespace {

constexpr double kMostDepth = 1e30;  // the brightest that a light may be: squares of it stay finite in error estimates
const Rgb kFront(0.1, 0.3, 1.0), kBack(1.0, 0.2, 0.1);

// The first primitive of the placed object that a primitive belongs to: one number for each instance of an instance.
uint64_t first_of_instance(const Scene& scene, uint64_t primitive) {
  uint64_t within = primitive;
  descend<false>(scene, within, [](const Instance&) {});
  return primitive - within;
}

// The same number has the same colour in every picture. No channel is below 0.1: none is taken for the background.
Rgb colour_of(uint64_t number) {
  uint32_t bits = hash_combine(static_cast<uint32_t>(number), static_cast<uint32_t>(number >> 32));
  Rgb unit(bits & 0x3ff, bits >> 10 & 0x7ff, bits >> 21);
  return 0.1 + 0.9 * unit / Rgb(0x3ff, 0x7ff, 0x7ff);
}

}  // namespace

Rgb trace_view(const Scene& scene, const Ray& ray, RayCounts& counts) {
  ++counts.camera;
  if (scene.integrator == Integrator::Cost) {
    TraversalCost cost;
    closest(scene, ray, cost);
    return Rgb(static_cast<double>(cost.steps + cost.tests));
  }
  Hit hit = closest(scene, ray);
  if (!hit.found()) return Rgb(0.0);
  switch (scene.integrator) {
    case Integrator::Normals: return glm::max(0.5 + 0.5 * resolve(scene, ray, hit).normal, 0.0);
    case Integrator::Depth: return Rgb(std::min(hit.t, kMostDepth));
    case Integrator::Primitives: return colour_of(hit.primitive);
    case Integrator::Instances: return colour_of(first_of_instance(scene, hit.primitive));
    default: {
      double cosine = std::fabs(glm::dot(resolve(scene, ray, hit).normal, ray.direction));
      return (0.2 + 0.8 * cosine) * (hit.entering ? kFront : kBack);
    }
  }
}

}  // namespace tilecast
