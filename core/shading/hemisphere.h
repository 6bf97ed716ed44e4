// Directions about the z axis with a density of cosine / pi: Malley's method.
#pragma once

#include "base/square_to_disk.h"

namespace tilecast {

inline Vec3 cosine_hemisphere(const Vec2& u) {
  Vec2 p = square_to_disk(u);
  return {p.x, p.y, std::sqrt(std::max(0.0, 1.0 - (p.x * p.x + p.y * p.y)))};
}

}  // namespace tilecast
