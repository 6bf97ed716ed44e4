// Ray queries for many rays, of which neighbours should be alike. Each gets the answer that scene/trace.h gives it alone, to
// the same bits; what is gained is that a CSG of few solids bounds eight rays at once (scene/csg_lanes.h).
#pragma once

#include <span>

#include "scene/trace.h"

namespace tilecast {

// Whether it pays to ask for many at once: where the scene has a CSG of solids.
bool has_lanes(const Scene& scene);

void closest(const Scene& scene, std::span<const Ray> rays, Hit* hits);
void occluded(const Scene& scene, std::span<const Ray> rays, bool* found);

}  // namespace tilecast
