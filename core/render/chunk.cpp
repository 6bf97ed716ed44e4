#include "render/chunk.h"

#include <optional>

#include "render/looks.h"
#include "render/plain_samples.h"
#include "render/whitted_samples.h"

namespace tilecast {

void check(const Tile& tile, const Camera& camera) {
  if (tile.x < 0 || tile.y < 0 || tile.width < 1 || tile.height < 1 || tile.width > camera.width() - tile.x ||
      tile.height > camera.height() - tile.y)
    throw Error("the tile lies outside of the image");
}

namespace {

ChunkSums black(const Scene& scene, const Tile& tile, uint32_t first, uint32_t count) {
  check(tile, scene.camera);
  if (count > UINT32_MAX - first) throw Error("sample indices go up to 2^32 - 1");
  ChunkSums out;
  out.sums.resize(size_t(2) * tile.width * tile.height * 3);
  return out;
}

void add_one_by_one(Samples& samples, const Tile& tile, uint32_t first, uint32_t count, std::vector<double>& sums) {
  const Scene& scene = samples.scene();
  const size_t plane = size_t(tile.width) * tile.height * 3;
  std::optional<Looks> looks;
  if (Looks::pays(scene, first, count)) looks.emplace(scene, tile, samples);
  const uint32_t odd = (first + count) / 2 - first / 2, of_half[2] = {count - odd, odd};
  for (int row = 0; row < tile.height; ++row)
    for (int column = 0; column < tile.width; ++column) {
      const int x = tile.x + column, y = tile.y + row;
      Rgb halves[2] = {Rgb(0.0), Rgb(0.0)};
      if (looks && looks->alike(x, y)) {
        for (int half = 0; half < 2; ++half) halves[half] = double(of_half[half]) * looks->at(x, y).first[half];
      } else {
        const bool lamps = samples.looks_for_lamps(x, y);
        for (uint32_t sample = first; sample < first + count; ++sample) halves[sample & 1] += samples.take(x, y, sample, lamps);
      }
      for (int half = 0; half < 2; ++half)
        for (int c = 0; c < 3; ++c) sums[half * plane + (size_t(row) * tile.width + column) * 3 + c] = halves[half][c];
    }
}

}  // namespace

ChunkSums render_chunk(const Scene& scene, const Tile& tile, uint32_t first, uint32_t count) {
  ChunkSums out = black(scene, tile, first, count);
  Samples samples(scene);
  if (const std::optional<PlainScene> plain = PlainScene::of(scene); plain && (!plain->glass || samples.in_vacuum()))
    PlainSamples(*plain, samples).add(tile, first, count, out.sums);
  else if (WhittedSamples::pays(scene) && !Looks::pays(scene, first, count))
    WhittedSamples(samples).add(tile, first, count, out.sums);
  else
    add_one_by_one(samples, tile, first, count, out.sums);
  out.rays = samples.rays();
  return out;
}

ChunkSums render_chunk_one_by_one(const Scene& scene, const Tile& tile, uint32_t first, uint32_t count) {
  ChunkSums out = black(scene, tile, first, count);
  Samples samples(scene);
  add_one_by_one(samples, tile, first, count, out.sums);
  out.rays = samples.rays();
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
