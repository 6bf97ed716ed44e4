// The first crossing of a CSG that has a filter (csg_filter.h).
#pragma once

#include "scene/trace.h"

namespace tilecast {

enum class Filtered : uint8_t { Nothing, Found, Unsure };

// The first crossing of the result in t_min < t <= t_max. `any`: whether there is one; `out` is not filled in.
Filtered first_crossing(const Scene& scene, const Csg& csg, const Ray& ray, double t_min, double t_max, uint64_t base,
                        bool any, Crossing& out);

}  // namespace tilecast
