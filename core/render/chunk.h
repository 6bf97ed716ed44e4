// One chunk: a tile and a range of sample indices. A pure function of the scene and its arguments.
#pragma once

#include <vector>

#include "integrators/integrator.h"

namespace tilecast {

struct Tile {
  int x, y, width, height;  // pixels from the top left of the image
};

// Refuses a tile that is not inside the image.
void check(const Tile& tile, const Camera& camera);

struct ChunkSums {
  // [2, height, width, 3]: linear RGB radiance summed over the even (0) and odd (1) sample indices.
  std::vector<double> sums;
  RayCounts rays;
};

// Samples first .. first + count - 1 of every pixel of the tile. Throws SampleError on a sample that is not finite or
// lies in too many media.
ChunkSums render_chunk(const Scene& scene, const Tile& tile, uint32_t first, uint32_t count);

// The same, bit for bit, without the shorter way that there is for plain scenes (integrators/plain_paths.h): for tests.
ChunkSums render_chunk_one_by_one(const Scene& scene, const Tile& tile, uint32_t first, uint32_t count);

// What the rays through the centres of the tile's pixels cost, summed.
TraversalCost camera_cost(const Scene& scene, const Tile& tile);

}  // namespace tilecast
