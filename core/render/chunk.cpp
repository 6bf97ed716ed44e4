#include "render/chunk.h"

#include <optional>

#include "base/error.h"
#include "integrators/plain_paths.h"
#include "render/camera_sample.h"
#include "render/lamps_in_view.h"

namespace tilecast {

void check(const Tile& tile, const Camera& camera) {
  if (tile.x < 0 || tile.y < 0 || tile.width < 1 || tile.height < 1 || tile.width > camera.width() - tile.x ||
      tile.height > camera.height() - tile.y)
    throw Error("the tile lies outside of the image");
}

namespace {

// The samples of pixels, one at a time.
class Samples {
 public:
  explicit Samples(const Scene& scene) : scene_(scene), media_(media_at(scene, scene.camera.position())), lamps_(scene) {}

  RayCounts& rays() { return tracing_.counts; }

  // Whether the pixel's samples look for lamps apart.
  bool looks_for_lamps(int x, int y) const { return media_.empty() && lamps_.at(x, y); }

  // Radiance, weighed by the filter.
  Rgb take(uint32_t x, uint32_t y, uint32_t sample, bool lamps) {
    double weight;
    const Rgb value = take(x, y, sample, weight, lamps ? Seen::Apart : Seen::ByPath);
    return lamps ? weight * value + look(x, y, sample) : weight * value;
  }

  // Radiance, and what the filter weighs it by.
  Rgb take(uint32_t x, uint32_t y, uint32_t sample, double& weight, Seen seen = Seen::ByPath) {
    Sampler sampler(x, y, sample, scene_.seed, scene_.sampling);
    const CameraSample at = sample_camera(scene_, x, y, sampler);
    if (many_origins_) media_ = media_at(scene_, at.ray.origin);
    const Rgb value = radiance(scene_, at.ray, media_, sampler, tracing_, seen);
    weight = at.weight;
    check(weight * value, x, y, sample);
    return value;
  }

  // The part of a sample that looks for lamps apart from its path.
  Rgb look(uint32_t x, uint32_t y, uint32_t sample) { return LampsInView::look(scene_, x, y, sample, tracing_); }

  void check(const Rgb& value, uint32_t x, uint32_t y, uint32_t sample) const {
    if (!is_finite(value))
      throw SampleError("a sample is not finite: pixel (" + std::to_string(x) + ", " + std::to_string(y) + "), sample " +
                        std::to_string(sample) + ", seed " + std::to_string(scene_.seed));
  }

 private:
  const Scene& scene_;
  Media media_;
  LampsInView lamps_;
  const bool many_origins_ = built_with("dielectric") && scene_.camera.has_extent() && scene_.dielectrics;
  Tracing tracing_;
};

// --- Adaptive antialiasing, after Whitted ("An Improved Illumination Model for Shaded Display", CACM 23(6), 1980): where the
// first samples of a pixel and of those around it are alike, they stand for the ones to come. He compares a pixel's
// corners; here every chunk that is long enough takes these samples again, so that it depends on no other.

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

// The samples of a chunk of a plain scene, many at a time. They are added up in the same order as one by one.
class PlainSamples {
 public:
  PlainSamples(const Scene& scene, const PlainScene& plain, Samples& samples, std::vector<double>& sums)
      : scene_(scene), samples_(samples), sums_(sums), paths_(std::make_unique<PlainPaths>(scene, plain)) {}

  // `place`: of the pixel's first channel in the sums of even samples; those of odd ones are `half` further on.
  void add(uint32_t x, uint32_t y, uint32_t pixel_key, uint32_t sample, bool lamps, size_t place, size_t half) {
    Sampler sampler(pixel_key, sample, scene_.sampling);
    const Seen seen = lamps ? Seen::Apart : Seen::ByPath;
    Added& added = added_[paths_->count()] = {x, y, sample, lamps, place + (sample & 1) * half, 1.0};
    if (by_pixels_) {
      paths_->add(x, y, sampler, seen);
    } else {
      const CameraSample at = sample_camera(scene_, x, y, sampler);
      added.weight = at.weight;
      paths_->add(at.ray, sampler, seen);
    }
    if (paths_->full()) finish();
  }
  void finish() {
    const uint32_t count = paths_->count();
    paths_->trace(samples_.rays());
    for (uint32_t i = 0; i < count; ++i) {
      const Added& a = added_[i];
      Rgb value = a.weight * paths_->radiance(i);
      samples_.check(value, a.x, a.y, a.sample);
      if (a.lamps) value += samples_.look(a.x, a.y, a.sample);
      for (int c = 0; c < 3; ++c) sums_[a.place + c] += value[c];
    }
  }

 private:
  struct Added {
    uint32_t x, y, sample;
    bool lamps;
    size_t place;
    double weight;
  };
  const Scene& scene_;
  Samples& samples_;
  std::vector<double>& sums_;
  const bool by_pixels_ = scene_.camera.is_pinhole() && scene_.filter.kind() == PixelFilter::Kind::Box;
  std::unique_ptr<PlainPaths> paths_;
  Added added_[PlainPaths::kSize];
};

ChunkSums render_samples(const Scene& scene, const Tile& tile, uint32_t first, uint32_t count, const PlainScene* plain) {
  check(tile, scene.camera);
  if (count > UINT32_MAX - first) throw Error("sample indices go up to 2^32 - 1");
  ChunkSums out;
  const size_t plane = size_t(tile.width) * tile.height * 3;
  out.sums.resize(2 * plane);
  Samples samples(scene);
  std::optional<PlainSamples> many;
  if (plain) many.emplace(scene, *plain, samples, out.sums);
  std::optional<Looks> looks;
  if (scene.contrast > 0.0 && first >= kLook && count >= kWorth) looks.emplace(scene, tile, samples);
  const uint32_t odd = (first + count) / 2 - first / 2, of_half[2] = {count - odd, odd};
  for (int row = 0; row < tile.height; ++row)
    for (int column = 0; column < tile.width; ++column) {
      const int x = tile.x + column, y = tile.y + row;
      if (many) {
        const uint32_t key = Sampler::key_of_pixel(x, y, scene.seed);
        const bool lamps = samples.looks_for_lamps(x, y);
        for (uint32_t sample = first; sample < first + count; ++sample)
          many->add(x, y, key, sample, lamps, (size_t(row) * tile.width + column) * 3, plane);
        continue;
      }
      Rgb halves[2] = {Rgb(0.0), Rgb(0.0)};
      if (looks && looks->alike(x, y)) {
        for (int half = 0; half < 2; ++half) halves[half] = double(of_half[half]) * looks->at(x, y).first[half];
      } else {
        const bool lamps = samples.looks_for_lamps(x, y);
        for (uint32_t sample = first; sample < first + count; ++sample) halves[sample & 1] += samples.take(x, y, sample, lamps);
      }
      for (int half = 0; half < 2; ++half)
        for (int c = 0; c < 3; ++c)
          out.sums[half * plane + (size_t(row) * tile.width + column) * 3 + c] = halves[half][c];
    }
  if (many) many->finish();
  out.rays = samples.rays();
  return out;
}

}  // namespace

ChunkSums render_chunk(const Scene& scene, const Tile& tile, uint32_t first, uint32_t count) {
  const std::optional<PlainScene> plain = PlainScene::of(scene);
  return render_samples(scene, tile, first, count, plain ? &*plain : nullptr);
}

ChunkSums render_chunk_one_by_one(const Scene& scene, const Tile& tile, uint32_t first, uint32_t count) {
  return render_samples(scene, tile, first, count, nullptr);
}

TraversalCost camera_cost(const Scene& scene, const Tile& tile) {
  check(tile, scene.camera);
  TraversalCost cost;
  for (int y = tile.y; y < tile.y + tile.height; ++y)
    for (int x = tile.x; x < tile.x + tile.width; ++x) closest(scene, scene.camera.ray(x + 0.5, y + 0.5), cost);
  return cost;
}

}  // namespace tilecast
