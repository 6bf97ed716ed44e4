// The samples of a chunk by Whitted's integrator, whose rays go together: neighbours of 4 x 2 pixels at a time. They are
// added up in the same order as one by one.
#pragma once

#include "base/sampler_lanes.h"
#include "render/chunk.h"
#include "render/samples.h"
#include "scene/packet.h"

namespace tilecast {

class WhittedSamples {
 public:
  // Whether it is faster.
  static bool pays(const Scene& scene) { return scene.integrator == Integrator::Whitted && has_lanes(scene); }

  explicit WhittedSamples(Samples& samples) : scene_(samples.scene()), samples_(samples) {}

  // Samples first .. first + count - 1 of each pixel of the tile, added to sums [2, height, width, 3].
  void add(const Tile& tile, uint32_t first, uint32_t count, std::vector<double>& sums) {
    const std::vector<Pixel> pixels = in_blocks(tile);
    const size_t plane = pixels.size() * 3, step = std::max<size_t>(kTogether / std::max(count, 1u), 1);
    for (size_t begin = 0; begin < pixels.size() && count > 0; begin += step) {
      const std::span<const Pixel> some = std::span(pixels).subspan(begin, std::min(step, pixels.size() - begin));
      take(some, first, count);
      for (size_t i = 0; i < rays_.size(); ++i) {
        const auto [x, y] = some[i / count];
        const uint32_t sample = first + static_cast<uint32_t>(i % count);
        const Rgb value = weights_[i] * rays_[i].value;
        samples_.check(value, x, y, sample);
        double* sum = &sums[(sample & 1) * plane + (size_t(y - tile.y) * tile.width + (x - tile.x)) * 3];
        for (int c = 0; c < 3; ++c) sum[c] += value[c];
      }
    }
  }

 private:
  struct Pixel {
    uint32_t x, y;
  };
  static constexpr size_t kTogether = 4096;  // samples

  static std::vector<Pixel> in_blocks(const Tile& tile) {
    constexpr int kWide = 4, kHigh = 2;
    std::vector<Pixel> out;
    out.reserve(size_t(tile.width) * tile.height);
    for (int top = 0; top < tile.height; top += kHigh)
      for (int left = 0; left < tile.width; left += kWide)
        for (int row = top; row < std::min(top + kHigh, tile.height); ++row)
          for (int column = left; column < std::min(left + kWide, tile.width); ++column)
            out.push_back({static_cast<uint32_t>(tile.x + column), static_cast<uint32_t>(tile.y + row)});
    return out;
  }

  // Traces them: rays_[i] is of pixels[i / count], sample first + i % count.
  void take(std::span<const Pixel> pixels, uint32_t first, uint32_t count) {
    const size_t all = pixels.size() * count;
    rays_.clear(), weights_.clear(), medias_.clear();
    rays_.reserve(all), medias_.reserve(all);
    auto pixel_of = [&](size_t i) { return count == 1 ? pixels[i] : pixels[i / count]; };
    auto sample_of = [&](size_t i) { return first + (count == 1 ? 0 : static_cast<uint32_t>(i % count)); };
        auto push = [&](const Ray& ray, const Sampler& sampler) {
      if (medias_.empty() || samples_.many_medias()) medias_.push_back(samples_.media(ray));
      rays_.push_back({ray, &medias_.back(), sampler});
    };
    size_t i = 0;
    if (has_camera_lanes(scene_))
      for (; i + kLanes <= all; i += kLanes) {
        Uint8Lanes x, y, sample;
        for (int lane = 0; lane < kLanes; ++lane) {
          const Pixel pixel = pixel_of(i + lane);
          x[lane] = pixel.x, y[lane] = pixel.y, sample[lane] = sample_of(i + lane);
        }
        const SamplerLanes<Uint8Lanes> samplers(x, y, sample, scene_.seed, scene_.sampling);
        Double8 right, down;
        samplers.next2(0, right, down);
        const Vec3Lanes directions = scene_.camera.pinhole_directions(lanes::to_double(x) + right, lanes::to_double(y) + down);
        for (int lane = 0; lane < kLanes; ++lane) push({scene_.camera.position(), directions[lane]}, samplers.lane(lane, 1));
      }
    weights_.assign(i, 1.0);
    for (; i < all; ++i) {
      const Pixel pixel = pixel_of(i);
      Sampler sampler(pixel.x, pixel.y, sample_of(i), scene_.seed, scene_.sampling);
      const CameraSample seen = sample_camera(scene_, pixel.x, pixel.y, sampler);
      push(seen.ray, sampler);
      weights_.push_back(seen.weight);
    }
    trace_whitted(scene_, rays_, samples_.tracing());
  }

  const Scene& scene_;
  Samples& samples_;
  std::vector<CameraRay> rays_;
  std::vector<double> weights_;
  std::vector<Media> medias_;  // around the rays' origins; one for all where it is the same
};

}  // namespace tilecast
