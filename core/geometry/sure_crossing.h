// One crossing of a solid that is known to be crossed twice, well apart: scene/csg_filter.h has found that out. The
// same digits as from `crossings`, by less work: one root of two, no error bounds, no look at whether there are any.
#pragma once

#include <optional>

#include "geometry/solid.h"

namespace tilecast {

// Crossing 0 (in) or 1 (out). False where it cannot be had after all.
bool sure_crossing(const Solid& solid, const Ray& line, int number, SolidCrossing& out);

// Whether that crossing lies at t > 0, by signs alone, without dividing or taking a root; nothing where they do not
// tell.
std::optional<bool> sure_crossing_ahead(const Solid& solid, const Ray& line, int number);

}  // namespace tilecast
