#include "optics/spectrum.h"

#include <algorithm>
#include <array>

#include "base/elementary.h"

namespace tilecast {
namespace {

constexpr double kD = 0.58756, kF = 0.48613, kC = 0.65627;  // micrometres
constexpr double kFirst = 0.4, kLast = 0.7;
constexpr int kBands = 60;

constexpr double inverse_square(double x) { return 1.0 / (x * x); }

Rgb linear_srgb(double nanometres) {
  auto lobe = [&](double height, double middle, double below, double above) {
    const double off = (nanometres - middle) / (nanometres < middle ? below : above);
    return height * exp_negative(-0.5 * off * off);
  };
  const double x = lobe(1.056, 599.8, 37.9, 31.0) + lobe(0.362, 442.0, 16.0, 26.7) - lobe(0.065, 501.1, 20.4, 26.2);
  const double y = lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1);
  const double z = lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8);
  return {3.2406 * x - 1.5372 * y - 0.4986 * z, -0.9689 * x + 1.8758 * y + 0.0415 * z, 0.0557 * x - 0.2040 * y + 1.0570 * z};
}

// Bands of one width, drawn by the sum of what they add.
struct Spectrum {
  std::array<double, kBands> up_to;  // the probability of a band and those before it
  std::array<Rgb, kBands> weight;

  Spectrum() {
    Rgb sum(0.0);
    for (int i = 0; i < kBands; ++i) {
      const double middle = kFirst + (kLast - kFirst) * (i + 0.5) / kBands;
      sum += weight[i] = glm::max(linear_srgb(1000.0 * middle), Rgb(0.0));
    }
    double before = 0.0;
    for (int i = 0; i < kBands; ++i) {
      weight[i] /= sum;
      const double probability = (weight[i].x + weight[i].y + weight[i].z) / 3.0;
      up_to[i] = before += probability;
      weight[i] = probability > 0.0 ? weight[i] / probability : Rgb(0.0);
    }
  }
};

}  // namespace

double cauchy_coefficient(double ior, double abbe) {
  return (ior - 1.0) / (abbe * (inverse_square(kF) - inverse_square(kC)));
}

double least_ior(double ior, double abbe) {
  const double end = ior < 1.0 ? kFirst : kLast;
  return ior + cauchy_coefficient(ior, abbe) * (inverse_square(end) - inverse_square(kD));
}

Wavelength sample_wavelength(double u) {
  static const Spectrum spectrum;
  const auto& up_to = spectrum.up_to;
  const int band = std::min(static_cast<int>(std::upper_bound(up_to.begin(), up_to.end(), u) - up_to.begin()), kBands - 1);
  const double before = band > 0 ? up_to[band - 1] : 0.0;
  const double within = std::min((u - before) / (up_to[band] - before), 1.0);
  const double wavelength = kFirst + (kLast - kFirst) * (band + within) / kBands;
  return {inverse_square(wavelength) - inverse_square(kD), spectrum.weight[band]};
}

}  // namespace tilecast
