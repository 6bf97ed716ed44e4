#include "scene/sky.h"

#include <algorithm>

#include "base/check.h"
#include "base/elementary.h"

namespace tilecast {
namespace {

constexpr int kSkyWidth = 512, kSkyHeight = 256;

// Perez's formula: how a quantity goes over the sky. a .. e are linear in the turbidity.
struct Perez {
  double a, b, c, d, e;

  // From the cosine of the angle to the zenith, and the angle to the sun (radians) with its cosine.
  double at(double cos_zenith, double to_sun, double cos_sun) const {
    return (1.0 + a * exp_negative(b / cos_zenith)) * (1.0 + c * exp_negative(d * to_sun) + e * cos_sun * cos_sun);
  }
};

// CIE xyY to linear sRGB (IEC 61966-2-1), what lies outside of it cut off.
Rgb to_rgb(double x, double y, double luminance) {
  const double X = x / y * luminance, Y = luminance, Z = (1.0 - x - y) / y * luminance;
  return glm::max(Rgb(3.2406 * X - 1.5372 * Y - 0.4986 * Z, -0.9689 * X + 1.8758 * Y + 0.0415 * Z,
                      0.0557 * X - 0.2040 * Y + 1.0570 * Z), 0.0);
}

}  // namespace

Environment make_environment(const Sky& sky) {
  if (!(max_abs(sky.sun) > 0.0) || !is_finite(sky.sun)) throw Error("sun_direction: must not be zero");
  const Vec3 sun = glm::normalize(sky.sun / max_abs(sky.sun));
  if (!(sun.y >= 0.0)) throw Error("sun_direction: must not point below the horizon");
  if (!(sky.turbidity >= 2.0 && sky.turbidity <= 10.0))
    throw Error("turbidity: must lie between 2 and 10, got " + text(sky.turbidity));
  if (!(sky.scale >= 0.0 && sky.scale <= 1e20))
    throw Error("scale: must lie between 0 and 1e20, got " + text(sky.scale));
  for (int i = 0; i < 3; ++i)
    if (!(sky.ground[i] >= 0.0 && sky.ground[i] <= 1.0)) throw Error("ground: must lie between 0 and 1");

  const double t = sky.turbidity;
  const Perez luminance{0.1787 * t - 1.4630, -0.3554 * t + 0.4275, -0.0227 * t + 5.3251, 0.1206 * t - 2.5771,
                        -0.0670 * t + 0.3703};
  const Perez chroma_x{-0.0193 * t - 0.2592, -0.0665 * t + 0.0008, -0.0004 * t + 0.2125, -0.0641 * t - 0.8989,
                       -0.0033 * t + 0.0452};
  const Perez chroma_y{-0.0167 * t - 0.2608, -0.0950 * t + 0.0092, -0.0079 * t + 0.2102, -0.0441 * t - 1.6537,
                       -0.0109 * t + 0.0529};
  const double s = 2.0 * kPi * turns_between(sun, Vec3(0.0, 1.0, 0.0)), s2 = s * s, s3 = s2 * s;
  const double chi = (4.0 / 9.0 - t / 120.0) * (kPi - 2.0 * s);
  const double zenith = (4.0453 * t - 4.9710) * tan_2pi(chi / (2.0 * kPi)) - 0.2155 * t + 2.4192;
  const double zenith_x = t * t * (0.00166 * s3 - 0.00375 * s2 + 0.00209 * s) +
                          t * (-0.02903 * s3 + 0.06377 * s2 - 0.03202 * s + 0.00394) +
                          0.11693 * s3 - 0.21196 * s2 + 0.06052 * s + 0.25886;
  const double zenith_y = t * t * (0.00275 * s3 - 0.00610 * s2 + 0.00317 * s) +
                          t * (-0.04214 * s3 + 0.08970 * s2 - 0.04153 * s + 0.00516) +
                          0.15346 * s3 - 0.26756 * s2 + 0.06670 * s + 0.26688;

  std::vector<Vec3f> pixels(size_t(kSkyWidth) * kSkyHeight);
  Rgb irradiance(0.0);
  for (int row = 0; row < kSkyHeight / 2; ++row) {
    double sine, cosine, half, ignored;
    sincos_2pi(0.5 * (row + 0.5) / kSkyHeight, sine, cosine);
    sincos_2pi(0.25 / kSkyHeight, half, ignored);
    for (int column = 0; column < kSkyWidth; ++column) {
      double across, ahead;
      const double turn = (column + 0.5) / kSkyWidth + 0.5;
      sincos_2pi(turn - std::floor(turn), across, ahead);
      const Vec3 direction(sine * across, cosine, -sine * ahead);
      const double to_sun = 2.0 * kPi * turns_between(direction, sun), cos_sun = glm::dot(direction, sun);
      auto quantity = [&](const Perez& perez, double at_zenith) {
        return at_zenith * perez.at(cosine, to_sun, cos_sun) / perez.at(1.0, s, sun.y);
      };
      const Rgb value = sky.scale * to_rgb(quantity(chroma_x, zenith_x), quantity(chroma_y, zenith_y),
                                           std::max(0.0, quantity(luminance, zenith)));
      pixels[size_t(row) * kSkyWidth + column] = Vec3f(value);
      irradiance += value * (cosine * 2.0 * sine * half * (2.0 * kPi / kSkyWidth));
    }
  }
  const Vec3f ground(sky.ground * irradiance * kInvPi);
  std::fill(pixels.begin() + pixels.size() / 2, pixels.end(), ground);
  return Environment(std::move(pixels), kSkyWidth, kSkyHeight, 0.0);
}

}  // namespace tilecast
