// The samples of a chunk of a plain scene, many at a time. They are added up in the same order as one by one.
#pragma once

#include "integrators/plain_paths.h"
#include "render/chunk.h"
#include "render/samples.h"

namespace tilecast {

class PlainSamples {
 public:
  PlainSamples(const PlainScene& plain, Samples& samples)
      : scene_(samples.scene()), samples_(samples), paths_(std::make_unique<PlainPaths>(scene_, plain)) {}

  // Samples first .. first + count - 1 of each pixel of the tile, added to sums [2, height, width, 3].
  void add(const Tile& tile, uint32_t first, uint32_t count, std::vector<double>& sums) {
    const size_t plane = size_t(tile.width) * tile.height * 3;
    for (int row = 0; row < tile.height; ++row)
      for (int column = 0; column < tile.width; ++column) {
        const uint32_t x = tile.x + column, y = tile.y + row, key = Sampler::key_of_pixel(x, y, scene_.seed);
        const bool lamps = samples_.looks_for_lamps(x, y);
        const size_t place = (size_t(row) * tile.width + column) * 3;
        for (uint32_t sample = first; sample < first + count; ++sample) {
          begin(key, {x, y, sample, lamps, place + (sample & 1) * plane, 1.0});
          if (paths_->full()) finish(sums);
        }
      }
    finish(sums);
  }

 private:
  struct Begun {
    uint32_t x, y, sample;
    bool lamps;
    size_t place;  // in the sums, of the first channel
    double weight;
  };

  void begin(uint32_t pixel_key, Begun sample) {
    Sampler sampler(pixel_key, sample.sample, scene_.sampling);
    const Seen seen = sample.lamps ? Seen::Apart : Seen::ByPath;
    const uint32_t number = paths_->count();
    if (has_camera_lanes(scene_)) {
      paths_->add(sample.x, sample.y, sampler, seen);
    } else {
      const CameraSample at = sample_camera(scene_, sample.x, sample.y, sampler);
      sample.weight = at.weight;
      paths_->add(at.ray, sampler, seen);
    }
    begun_[number] = sample;
  }
  void finish(std::vector<double>& sums) {
    const uint32_t count = paths_->count();
    paths_->trace(samples_.tracing());
    for (uint32_t i = 0; i < count; ++i) {
      const Begun& b = begun_[i];
      Rgb value = b.weight * paths_->radiance(i);
      samples_.check(value, b.x, b.y, b.sample);
      if (b.lamps) value += samples_.look(b.x, b.y, b.sample);
      for (int c = 0; c < 3; ++c) sums[b.place + c] += value[c];
    }
  }

  const Scene& scene_;
  Samples& samples_;
  std::unique_ptr<PlainPaths> paths_;
  Begun begun_[PlainPaths::kSize];
};

}  // namespace tilecast
