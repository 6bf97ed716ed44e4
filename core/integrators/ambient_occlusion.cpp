// Zhukov, Iones and Kronin, "An Ambient Light Illumination Model", EGWR 1998.
#include "base/counters.h"
#include "integrators/integrator.h"
#include "shading/basis.h"
#include "shading/hemisphere.h"

namespace tilecast {

Rgb trace_ambient_occlusion(const Scene& scene, const Ray& ray, Sampler& sampler, RayCounts& counts) {
  ++counts.camera;
  Hit hit = closest(scene, ray);
  if (!hit.found()) return Rgb(1.0);
  Surface surface = resolve(scene, ray, hit);
  Basis basis(hit.entering ? surface.normal : -surface.normal);
  Vec3 direction = glm::normalize(basis.to_world(cosine_hemisphere(sampler.next2())));
  TILECAST_COUNT(shadow);
  ++counts.shadow;
  return Rgb(occluded(scene, {surface.spawn(direction), direction, 0.0, scene.ao_distance}) ? 0.0 : 1.0);
}

}  // namespace tilecast
