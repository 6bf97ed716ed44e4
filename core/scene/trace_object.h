// The queries of scene/trace.h in the space of one object, for one ray.
#pragma once

#include "scene/trace.h"

namespace tilecast {

// Puts the object's first hit, whose primitives are numbered from `base`, in the place of a later one.
void closest(const Scene& scene, const Object& object, const Ray& ray, uint64_t base, Hit& best);
bool occluded(const Scene& scene, const Object& object, const Ray& ray);

}  // namespace tilecast
