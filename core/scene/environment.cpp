#include "scene/environment.h"

#include <algorithm>

#include "base/check.h"
#include "base/elementary.h"

namespace tilecast {
namespace {

constexpr float kBrightest = 1e30f;
constexpr size_t kMostPixels = size_t(1) << 25;  // 8192 x 4096

double luminance(const Vec3f& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

// Sine and cosine of the angle from +y at a row's edge, in pixels from the top.
void polar(double down, int height, double& sine, double& cosine) { sincos_2pi(0.5 * down / height, sine, cosine); }

}  // namespace

Environment::Environment(std::vector<Vec3f> pixels, int width, int height, double rotation)
    : pixels_(std::move(pixels)), width_(width), height_(height), rotation_(rotation / 360.0) {
  if (width < 1 || height < 1 || size_t(width) * height > kMostPixels || pixels_.size() != size_t(width) * height)
    throw Error("an environment has at least 1 and at most 2^25 pixels, got " + std::to_string(width) + " x " +
                std::to_string(height));
  if (!(std::fabs(rotation) <= 1e6)) throw Error("rotation: must lie between -1e6 and 1e6, got " + text(rotation));
  for (size_t i = 0; i < pixels_.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      float& value = pixels_[i][c];
      if (!(std::fabs(value) <= kBrightest))  // NaN too
        throw Error("pixel (" + std::to_string(i % width) + ", " + std::to_string(i / width) + ") is " + text(value) +
                    ": values must be at most 1e30");
      value = std::max(value, 0.0f);
    }
  // The mean over a pixel of what is interpolated: 1/8, 3/4 and 1/8 of it and its neighbours, both ways.
  std::vector<double> rows(3 * size_t(width));
  auto blurred = [&](int row, double* out) {
    for (int x = 0; x < width; ++x)
      out[x] = 0.125 * luminance(pixel((x + width - 1) % width, row)) + 0.75 * luminance(pixel(x, row)) +
               0.125 * luminance(pixel((x + 1) % width, row));
  };
  across_.resize(pixels_.size());
  down_.resize(height);
  double *above = &rows[0], *here = &rows[width], *below = &rows[2 * size_t(width)];
  blurred(0, here);
  std::copy_n(here, width, above);
  double sine, cosine, half;
  polar(0.5, height, half, cosine);
  for (int y = 0; y <= height; ++y) {
    polar(y, height, sine, cosine);
    edges_.push_back(cosine);
  }
  for (int y = 0; y < height; ++y) {
    blurred(std::min(y + 1, height - 1), below);
    double sum = 0.0;
    for (int x = 0; x < width; ++x)
      across_[size_t(y) * width + x] = sum += 0.125 * above[x] + 0.75 * here[x] + 0.125 * below[x];
    polar(y + 0.5, height, sine, cosine);
    down_[y] = total_ += sum * (2.0 * kPi / width) * 2.0 * sine * half;
    to_column_.emplace_back(std::span(&across_[size_t(y) * width_], width_ - 1), (width_ + 3) / 4);
    std::swap(above, here);
    std::swap(here, below);
  }
  to_row_ = Guide(std::span(down_.data(), height_ - 1), height_);
}

Environment::Place Environment::place_of(const Vec3& d) const {
  double turn = atan2_turns(d.x, -d.z) + rotation_ + 0.5;
  turn -= std::floor(turn);
  return {turn * width_, 2.0 * atan2_turns(std::sqrt(d.x * d.x + d.z * d.z), d.y) * height_};
}

Rgb Environment::radiance(const Vec3& direction) const {
  const Place place = place_of(direction);
  const double x = place.across - 0.5, y = std::clamp(place.down - 0.5, 0.0, height_ - 1.0);
  const double left = std::floor(x), up = std::floor(y), a = x - left, b = y - up;
  const int x0 = (static_cast<int>(left) + width_) % width_, x1 = (x0 + 1) % width_;
  const int y0 = static_cast<int>(up), y1 = std::min(y0 + 1, height_ - 1);
  return (1.0 - b) * ((1.0 - a) * Rgb(pixel(x0, y0)) + a * Rgb(pixel(x1, y0))) +
         b * ((1.0 - a) * Rgb(pixel(x0, y1)) + a * Rgb(pixel(x1, y1)));
}

double Environment::density(int column, int row) const {
  const double* sums = &across_[size_t(row) * width_];
  return (sums[column] - (column > 0 ? sums[column - 1] : 0.0)) / total_;
}

Environment::Sample Environment::sample(const Vec2& u) const {
  const double mass = u.y * total_;
  const int row = static_cast<int>(to_row_.above(down_.data(), mass));
  const double before = row > 0 ? down_[row - 1] : 0.0;
  const double* sums = &across_[size_t(row) * width_];
  const double part = u.x * sums[width_ - 1];
  const int column = static_cast<int>(to_column_[row].above(sums, part));
  const double start = column > 0 ? sums[column - 1] : 0.0;
  const double pdf = density(column, row);
  if (!(pdf > 0.0) || !(down_[row] > before)) return {Vec3(0.0, 1.0, 0.0), 0.0};
  // Uniform over the pixel's solid angle: in the azimuth and in the cosine.
  const double turn = (column + (part - start) / (sums[column] - start)) / width_ - 0.5 - rotation_;
  const double y = edges_[row] + (mass - before) / (down_[row] - before) * (edges_[row + 1] - edges_[row]);
  const double r = std::sqrt(std::max(0.0, (1.0 - y) * (1.0 + y)));
  double sine, cosine;
  sincos_2pi(turn - std::floor(turn), sine, cosine);
  return {glm::normalize(Vec3(r * sine, y, -r * cosine)), pdf};
}

double Environment::pdf(const Vec3& direction) const {
  if (black()) return 0.0;
  const Place place = place_of(direction);
  return density(std::min(static_cast<int>(place.across), width_ - 1),
                 std::min(static_cast<int>(place.down), height_ - 1));
}

}  // namespace tilecast
