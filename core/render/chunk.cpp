#include "render/chunk.h"

#include <optional>

#include "base/error.h"
#include "base/sampler_lanes.h"
#include "render/camera_sample.h"
#include "scene/packet.h"

namespace tilecast {

void check(const Tile& tile, const Camera& camera) {
  if (tile.x < 0 || tile.y < 0 || tile.width < 1 || tile.height < 1 || tile.width > camera.width() - tile.x ||
      tile.height > camera.height() - tile.y)
    throw Error("the tile lies outside of the image");
}

namespace {

struct Pixel {
  uint32_t x, y;
};

// The samples of pixels, one at a time or many at once.
class Samples {
 public:
  explicit Samples(const Scene& scene) : scene_(scene), media_(media_at(scene, scene.camera.position())) {}

  const RayCounts& rays() const { return tracing_.counts; }

  // Radiance, and what the filter weighs it by.
  Rgb take(uint32_t x, uint32_t y, uint32_t sample, double& weight) {
    Sampler sampler(x, y, sample, scene_.seed, scene_.sampling);
    const CameraSample seen = sample_camera(scene_, x, y, sampler);
    if (many_origins_) media_ = media_at(scene_, seen.ray.origin);
    const Rgb value = radiance(scene_, seen.ray, media_, sampler, tracing_);
    weight = seen.weight;
    check(weight * value, x, y, sample);
    return value;
  }

  // Whether take() of many at once is faster, with the same values.
  bool together() const { return scene_.integrator == Integrator::Whitted && has_lanes(scene_); }

  // Samples first .. first + count - 1 of each of the pixels; add(pixel, sample, weighted value).
  template <class Add>
  void take(std::span<const Pixel> pixels, uint32_t first, uint32_t count, Add&& add) {
    rays_.clear(), weights_.clear(), medias_.clear();
    rays_.reserve(pixels.size() * count);
    const size_t all = pixels.size() * count;
    auto pixel_of = [&](size_t i) { return count == 1 ? pixels[i] : pixels[i / count]; };
    auto sample_of = [&](size_t i) { return first + (count == 1 ? 0 : static_cast<uint32_t>(i % count)); };
    size_t i = 0;
    if (has_camera_lanes(scene_))
      for (; i + kLanes <= all; i += kLanes) {
        Uint8Lanes x, y, sample;
        for (int lane = 0; lane < kLanes; ++lane) {
          const Pixel pixel = pixel_of(i + lane);
          x[lane] = pixel.x, y[lane] = pixel.y, sample[lane] = sample_of(i + lane);
        }
        SamplerLanes samplers(x, y, sample, scene_.seed, scene_.sampling);
        Double8 right, down, column, row;
        samplers.next2(right, down);
        for (int lane = 0; lane < kLanes; ++lane) column.set(lane, x[lane]), row.set(lane, y[lane]);
        const Vec3Lanes directions = scene_.camera.pinhole_directions(column + right, row + down);
        for (int lane = 0; lane < kLanes; ++lane)
          rays_.push_back({{scene_.camera.position(), directions[lane]}, &media_, samplers.lane(lane)});
      }
    weights_.assign(i, 1.0);
    for (; i < all; ++i) {
      const Pixel pixel = pixel_of(i);
      Sampler sampler(pixel.x, pixel.y, sample_of(i), scene_.seed, scene_.sampling);
      const CameraSample seen = sample_camera(scene_, pixel.x, pixel.y, sampler);
      rays_.push_back({seen.ray, &media_, sampler});
      weights_.push_back(seen.weight);
    }
    if (many_origins_) {
      for (const CameraRay& ray : rays_) medias_.push_back(media_at(scene_, ray.ray.origin));
      for (size_t i = 0; i < rays_.size(); ++i) rays_[i].media = &medias_[i];
    }
    trace_whitted(scene_, rays_, tracing_);
    for (i = 0; i < all; ++i) {
      const Pixel pixel = pixel_of(i);
      const Rgb value = weights_[i] * rays_[i].value;
      check(value, pixel.x, pixel.y, sample_of(i));
      add(pixel, sample_of(i), value);
    }
  }

 private:
  void check(const Rgb& value, uint32_t x, uint32_t y, uint32_t sample) const {
    if (!is_finite(value))
      throw SampleError("a sample is not finite: pixel (" + std::to_string(x) + ", " + std::to_string(y) + "), sample " +
                        std::to_string(sample) + ", seed " + std::to_string(scene_.seed));
  }

  const Scene& scene_;
  Media media_;
  const bool many_origins_ = built_with("dielectric") && scene_.camera.has_extent() && scene_.dielectrics;
  Tracing tracing_;
  std::vector<CameraRay> rays_;
  std::vector<double> weights_;
  std::vector<Media> medias_;
};

// A tile's pixels, neighbours together: in blocks of eight.
std::vector<Pixel> in_blocks(const Tile& tile) {
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

// --- Adaptive antialiasing, after Whitted ("An Improved Illumination Model for Shaded Display", CACM 23(6), 1980): where the
// first samples of a pixel and of those around it are alike, they stand for the ones to come. He compares a pixel's
// corners; here every chunk that is long enough takes these samples again, so that it depends on no other.

constexpr size_t kTogether = 4096;  // samples
constexpr uint32_t kLook = 2;    // samples that are compared, one of each half
constexpr uint32_t kWorth = 8;   // samples of a chunk that it pays for
constexpr double kNoLess = 0.1;  // added to brightness, so that in the dark little counts: the root of what the error adds

struct Look {
  Rgb first[kLook];  // even and odd
  Rgb lo{kInfinity}, hi{-kInfinity};

  void add(const Rgb& value) { lo = glm::min(lo, value), hi = glm::max(hi, value); }
};

// Of the tile's pixels, and around it of those of the image.
class Looks {
 public:
  Looks(const Scene& scene, const Tile& tile, Samples& samples)
      : x_(std::max(tile.x - 1, 0)), y_(std::max(tile.y - 1, 0)),
        right_(std::min(tile.x + tile.width + 1, scene.camera.width())),
        bottom_(std::min(tile.y + tile.height + 1, scene.camera.height())), contrast_(scene.contrast) {
    looks_.reserve(size_t(right_ - x_) * (bottom_ - y_));
    double ignored;
    for (int y = y_; y < bottom_; ++y)
      for (int x = x_; x < right_; ++x) {
        Look look;
        for (uint32_t sample = 0; sample < kLook; ++sample) look.add(look.first[sample] = samples.take(x, y, sample, ignored));
        looks_.push_back(look);
      }
  }

  const Look& at(int x, int y) const { return looks_[size_t(y - y_) * (right_ - x_) + (x - x_)]; }

  bool alike(int x, int y) const {
    Look all = at(x, y);
    for (int v = std::max(y - 1, y_); v < std::min(y + 2, bottom_); ++v)
      for (int u = std::max(x - 1, x_); u < std::min(x + 2, right_); ++u) all.add(at(u, v).lo), all.add(at(u, v).hi);
    for (int c = 0; c < 3; ++c)
      if (!(all.hi[c] - all.lo[c] <= contrast_ * (0.5 * (all.hi[c] + all.lo[c]) + kNoLess))) return false;
    return true;
  }

 private:
  int x_, y_, right_, bottom_;
  double contrast_;
  std::vector<Look> looks_;
};

}  // namespace

ChunkSums render_chunk(const Scene& scene, const Tile& tile, uint32_t first, uint32_t count) {
  check(tile, scene.camera);
  if (count > UINT32_MAX - first) throw Error("sample indices go up to 2^32 - 1");
  ChunkSums out;
  const size_t plane = size_t(tile.width) * tile.height * 3;
  out.sums.resize(2 * plane);
  Samples samples(scene);
  std::optional<Looks> looks;
  if (scene.contrast > 0.0 && first >= kLook && count >= kWorth) looks.emplace(scene, tile, samples);
  if (!looks && samples.together()) {
    const std::vector<Pixel> pixels = in_blocks(tile);
    const size_t step = std::max<size_t>(kTogether / std::max(count, 1u), 1);
    for (size_t begin = 0; begin < pixels.size() && count > 0; begin += step) {
      const std::span<const Pixel> some = std::span(pixels).subspan(begin, std::min(step, pixels.size() - begin));
      samples.take(some, first, count, [&](const Pixel& pixel, uint32_t sample, const Rgb& value) {
        double* sum = &out.sums[(sample & 1) * plane + (size_t(pixel.y - tile.y) * tile.width + (pixel.x - tile.x)) * 3];
        for (int c = 0; c < 3; ++c) sum[c] += value[c];
      });
    }
    out.rays = samples.rays();
    return out;
  }
  const uint32_t odd = (first + count) / 2 - first / 2, of_half[2] = {count - odd, odd};
  for (int row = 0; row < tile.height; ++row)
    for (int column = 0; column < tile.width; ++column) {
      const int x = tile.x + column, y = tile.y + row;
      Rgb halves[2] = {Rgb(0.0), Rgb(0.0)};
      if (looks && looks->alike(x, y)) {
        for (int half = 0; half < 2; ++half) halves[half] = double(of_half[half]) * looks->at(x, y).first[half];
      } else {
        for (uint32_t sample = first; sample < first + count; ++sample) {
          double weight;
          const Rgb value = samples.take(x, y, sample, weight);
          halves[sample & 1] += weight * value;
        }
      }
      for (int half = 0; half < 2; ++half)
        for (int c = 0; c < 3; ++c)
          out.sums[half * plane + (size_t(row) * tile.width + column) * 3 + c] = halves[half][c];
    }
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
