// An order of rays in which neighbours meet the same nodes, so that these are still in the cache (Pharr, Kolb,
// Gershbein and Hanrahan, "Rendering Complex Scenes with Memory-Coherent Ray Tracing", SIGGRAPH 1997; keys as in
// Moon et al., "Cache-Oblivious Ray Reordering", TOG 29(3), 2010).
#pragma once

#include <span>
#include <vector>

#include "base/frame.h"

namespace tilecast {

// Empty where the rays are few, or neighbours already are alike.
std::vector<uint32_t> order_for_cache(const Frame& frame, std::span<const Ray> rays);

}  // namespace tilecast
