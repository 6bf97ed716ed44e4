// What of a spectrum dispersion needs: how the index of refraction follows the wavelength, and what a wavelength adds to
// red, green and blue.
#pragma once

#include "base/vec.h"

namespace tilecast {

// Cauchy's n(w) = n_d + b (1 / w^2 - 1 / d^2) for a wavelength w in micrometres, d being that of the yellow line of helium
// for which indices are told, 0.58756. The coefficient b, in square micrometres, follows from Abbe's number, (n_d - 1) /
// (n_F - n_C), of the blue and the red line of hydrogen.
double cauchy_coefficient(double ior, double abbe);

inline constexpr double kLeastIor = 1e-3;  // that a material may have, at any wavelength

// The least index of refraction of all visible wavelengths.
double least_ior(double ior, double abbe);

struct Wavelength {
  double shift;  // 1 / w^2 - 1 / d^2: what the coefficient above is multiplied by
  Rgb weight;    // its part in light that is 1, 1, 1 at all wavelengths together, over the density that it was drawn with
};

// A visible wavelength for u in [0, 1): the average of the weights is 1, 1, 1. They are those of linear sRGB by the CIE's
// observer of 1931 (Wyman, Sloan and Shirley, "Simple Analytic Approximations to the CIE XYZ Color Matching Functions", JCGT
// 2(2), 2013), where these are above zero: the purest colours are paler than they should be, and no light is negative.
Wavelength sample_wavelength(double u);

}  // namespace tilecast
