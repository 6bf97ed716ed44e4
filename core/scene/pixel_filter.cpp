#include "scene/pixel_filter.h"

#include "base/elementary.h"

namespace tilecast {
namespace {

constexpr int kCells = 448;  // a multiple of 7: Mitchell's filter changes its sign at 8/7 of 2, between two cells
constexpr double kNegativeFrom = 8.0 / 7.0;
constexpr double kGaussianSpread = 0.5;  // standard deviation of the Gaussian, pixels

double gaussian(double x) { return exp_negative(-0.5 * x * x / (kGaussianSpread * kGaussianSpread)); }

// Mitchell and Netravali, "Reconstruction Filters in Computer Graphics", SIGGRAPH 1988, with B = C = 1/3.
double mitchell(double x) {
  if (x < 1.0) return ((7.0 * x - 12.0) * x * x + 16.0 / 3.0) / 6.0;
  return -(x - 2.0) * (x - 2.0) * (7.0 * x - 8.0) / 18.0;
}

// Harris, "On the Use of Windows for Harmonic Analysis with the Discrete Fourier Transform", Proc. IEEE 66(1), 1978:
// four terms, minimal.
double blackman_harris(double turn) {
  double sine, c1, c2, c3;
  sincos_2pi(turn, sine, c1);
  c2 = 2.0 * c1 * c1 - 1.0;
  c3 = (2.0 * c2 - 1.0) * c1;
  return 0.35875 - 0.48829 * c1 + 0.14128 * c2 - 0.01168 * c3;
}

}  // namespace

double PixelFilter::radius(Kind kind) {
  switch (kind) {
    case Kind::Box: return 0.5;
    case Kind::Tent: return 1.0;
    case Kind::BlackmanHarris: return 1.5;
    default: return 2.0;
  }
}

double PixelFilter::profile(Kind kind, double x) {
  x = std::fabs(x);
  if (x >= radius(kind)) return 0.0;
  switch (kind) {
    case Kind::Box: return 1.0;
    case Kind::Tent: return 1.0 - x;
    case Kind::Gaussian: return gaussian(x) - gaussian(radius(kind));  // falls to 0
    case Kind::BlackmanHarris: return blackman_harris(0.5 - x / (2.0 * radius(kind)));
    default: return mitchell(x);
  }
}

PixelFilter::PixelFilter(Kind kind) : kind_(kind), radius_(radius(kind)), negative_from_(1.0) {
  if (kind == Kind::Box) return;
  const double width = radius_ / kCells;
  double positive = 0.0, negative = 0.0;
  cumulative_.push_back(0.0);
  for (int i = 0; i < kCells; ++i) {  // Simpson's rule; the last point lies on the edge, where all of them are 0
    const double x = i * width;
    const double part = (profile(kind, x) + 4.0 * profile(kind, x + 0.5 * width) + profile(kind, x + width)) / 6.0;
    (part < 0.0 ? negative : positive) += std::fabs(part);
    cumulative_.push_back(positive + negative);
  }
  const double total = positive + negative;
  for (double& c : cumulative_) c /= total;
  cumulative_.back() = 1.0;
  guide_ = Guide(std::span(cumulative_).subspan(1, kCells - 1), kCells);
  if (kind == Kind::Mitchell) negative_from_ = cumulative_[static_cast<size_t>(std::rint(kNegativeFrom / width))];
  const double along = total / (positive - negative);
  norm_ = along * along;
}

double PixelFilter::along(double u, double& weight) const {
  const double side = 2.0 * u - 1.0, v = std::fabs(side);
  if (v > negative_from_) weight = -weight;
  const size_t cell = guide_.above(&cumulative_[1], v);
  const double low = cumulative_[cell], high = cumulative_[cell + 1];
  return std::copysign(radius_ / kCells * (static_cast<double>(cell) + (v - low) / (high - low)), side);
}

}  // namespace tilecast
