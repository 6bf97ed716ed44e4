// How samples are spread around the middle of a pixel, so that each belongs to one pixel: filter importance sampling
// (Ernst, Stamminger and Greiner, "Filter Importance Sampling", RT 2006).
//
// A filter f(x) f(y) is sampled by |f|, by the inverse of a table of its integral. The mean of
// weight * value is the convolution with the normalised filter. Where f is not negative, all weights are 1; the box
// has no table.
#pragma once

#include <vector>

#include "base/guide.h"
#include "base/vec.h"

namespace tilecast {

class PixelFilter {
 public:
  enum class Kind : uint8_t { Box, Tent, Gaussian, BlackmanHarris, Mitchell };

  explicit PixelFilter(Kind kind = Kind::Box);

  // A place in pixels from the pixel's top left corner, for u in [0, 1)^2; `weight` receives that of its value.
  Vec2 sample(const Vec2& u, double& weight) const {
    if (kind_ == Kind::Box) return u;
    weight = norm_;
    return {0.5 + along(u.x, weight), 0.5 + along(u.y, weight)};
  }

  Kind kind() const { return kind_; }
  // Half of its width, pixels.
  static double radius(Kind kind);
  // f, in pixels from the middle; not normalised.
  static double profile(Kind kind, double x);

 private:
  double along(double u, double& weight) const;

  Kind kind_;
  double radius_, norm_ = 1.0;     // norm_: of |f| over that of f, in two dimensions
  double negative_from_;           // where |f|'s integral meets the negative lobe
  std::vector<double> cumulative_; // of |f| over [0, radius], at the ends of its cells; the last is 1
  Guide guide_;                    // to the ends of all cells but the last
};

inline constexpr const char* kFilterNames[]{"box", "tent", "gaussian", "blackman-harris", "mitchell"};

}  // namespace tilecast
