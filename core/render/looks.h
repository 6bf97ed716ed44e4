// Adaptive antialiasing, after Whitted ("An Improved Illumination Model for Shaded Display", CACM 23(6), 1980): where the
// first samples of a pixel and of those around it are alike, they stand for the ones to come. He compares a pixel's
// corners; here every chunk that is long enough takes these samples again, so that it depends on no other.
#pragma once

#include "render/chunk.h"
#include "render/samples.h"

namespace tilecast {

inline constexpr uint32_t kLook = 2;    // samples that are compared, one of each half
inline constexpr uint32_t kWorth = 8;   // samples of a chunk that it pays for
inline constexpr double kNoLess = 0.1;  // added to brightness, so that in the dark little counts: the root of what the error adds

struct Look {
  Rgb first[kLook];  // even and odd
  Rgb lo{kInfinity}, hi{-kInfinity};

  void add(const Rgb& value) { lo = glm::min(lo, value), hi = glm::max(hi, value); }
};

// Of the tile's pixels, and around it of those of the image.
class Looks {
 public:
  // Whether a chunk of these samples takes them.
  static bool pays(const Scene& scene, uint32_t first, uint32_t count) {
    return scene.contrast > 0.0 && first >= kLook && count >= kWorth;
  }

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

}  // namespace tilecast
