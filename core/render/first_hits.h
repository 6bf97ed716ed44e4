// What the camera sees first in each pixel, without light: colour, direction and distance of the surface. A pure
// function of the scene and the tile; no render pays for it.
#pragma once

#include <vector>

#include "render/chunk.h"

namespace tilecast {

inline constexpr int kFirstHitChannels = 7;

// [height, width, 7]: albedo (red, green, blue), normal (x, y, z: geometric, outward, world space), distance along the
// ray in metres. Means over the first `samples` of each pixel, along the rays that the image's own samples take. Where
// nothing is hit, albedo and normal are 0; the distance is the mean of those that hit, and 0 where none does.
std::vector<float> first_hits(const Scene& scene, const Tile& tile, uint32_t samples);

}  // namespace tilecast
