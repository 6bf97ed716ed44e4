#include "render/chunk.h"

#include <optional>

#include "base/error.h"
#include "render/camera_sample.h"

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
  explicit Samples(const Scene& scene) : scene_(scene), media_(media_at(scene, scene.camera.position())) {}

  const RayCounts& rays() const { return tracing_.counts; }

  // Radiance, and what the filter weighs it by.
  Rgb take(uint32_t x, uint32_t y, uint32_t sample, double& weight) {
    Sampler sampler(x, y, sample, scene_.seed, scene_.sampling);
    const CameraSample seen = sample_camera(scene_, x, y, sampler);
    if (many_origins_) media_ = media_at(scene_, seen.ray.origin);
    const Rgb value = radiance(scene_, seen.ray, media_, sampler, tracing_);
    weight = seen.weight;
    if (!is_finite(weight * value))
      throw SampleError("a sample is not finite: pixel (" + std::to_string(x) + ", " + std::to_string(y) + "), sample " +
                        std::to_string(sample) + ", seed " + std::to_string(scene_.seed));
    return value;
  }

 private:
  const Scene& scene_;
  Media media_;
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
