#include "shading/medium.h"

#include "base/counters.h"
#include "base/error.h"

namespace tilecast {

void Media::refuse() {
  throw SampleError("more than " + std::to_string(kMost) + " dielectrics fill one place, entered one in the other: " +
                    "take some of them away where they overlap");
}

Media media_at(const Scene& scene, const Vec3& point) {
  Media media;
  if (!built_with("dielectric") || !scene.dielectrics) return media;
  const Box& all = scene.objects[scene.root].bounds;
  if (glm::any(glm::lessThan(point, all.lo)) || glm::any(glm::greaterThan(point, all.hi))) return media;
  TILECAST_COUNT(medium);
  Ray line{point, Vec3(0.0, 1.0, 0.0), -kInfinity, kInfinity};
  std::vector<Crossing> list;
  crossings(scene, line, list);
  for (const Crossing& crossing : list) {
    if (crossing.t > 0.0) break;
    media.cross(*resolve(scene, line, crossing).material, crossing.entering);
  }
  return media;
}

}  // namespace tilecast
