#include "render/chunk.h"

#include "base/error.h"
#include "render/camera_sample.h"

namespace tilecast {

void check(const Tile& tile, const Camera& camera) {
  if (tile.x < 0 || tile.y < 0 || tile.width < 1 || tile.height < 1 || tile.width > camera.width() - tile.x ||
      tile.height > camera.height() - tile.y)
    throw Error("the tile lies outside of the image");
}

ChunkSums render_chunk(const Scene& scene, const Tile& tile, uint32_t first, uint32_t count) {
  const Camera& camera = scene.camera;
  check(tile, camera);
  if (count > UINT32_MAX - first) throw Error("sample indices go up to 2^32 - 1");
  ChunkSums out;
  size_t plane = size_t(tile.width) * tile.height * 3;
  out.sums.resize(2 * plane);
  Tracing tracing;
  const bool many_origins = built_with("dielectric") && camera.has_extent() && scene.dielectrics;
  Media media = media_at(scene, camera.position());
  for (int row = 0; row < tile.height; ++row)
    for (int column = 0; column < tile.width; ++column) {
      uint32_t x = tile.x + column, y = tile.y + row;
      Rgb halves[2] = {Rgb(0.0), Rgb(0.0)};
      for (uint32_t sample = first; sample < first + count; ++sample) {
        Sampler sampler(x, y, sample, scene.seed, scene.sampling);
        const CameraSample seen = sample_camera(scene, x, y, sampler);
        if (many_origins) media = media_at(scene, seen.ray.origin);
        Rgb value = seen.weight * radiance(scene, seen.ray, media, sampler, tracing);
        if (!is_finite(value))
          throw SampleError("a sample is not finite: pixel (" + std::to_string(x) + ", " + std::to_string(y) +
                            "), sample " + std::to_string(sample) + ", seed " + std::to_string(scene.seed));
        halves[sample & 1] += value;
      }
      for (int half = 0; half < 2; ++half)
        for (int c = 0; c < 3; ++c)
          out.sums[half * plane + (size_t(row) * tile.width + column) * 3 + c] = halves[half][c];
    }
  out.rays = tracing.counts;
  return out;
}

TraversalCost camera_cost(const Scene& scene, const Tile& tile) {
  check(tile, scene.camera);
  TraversalCost cost;
  for (int y = tile.y; y < tile.y + tile.height; ++y)
    for (int x = tile.x; x < tile.x + tile.width; ++x) closest(scene, scene.camera.ray(x + 0.5, y + 0.5), cost);
  return cost;
}

}  // namespace tilecast
