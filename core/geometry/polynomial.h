// Quartics with coefficients of twice the precision: where one is negative within an interval, and how far its roots
// can be off.
//
// Brackets from the extrema: Newton's method cannot leave the bracket that a change of sign proves, so no root is lost
// or found twice. Compare Yuksel, "High-Performance Polynomial Root Finding for Graphics", HPG 2022.
#pragma once

#include <array>

#include "base/twofold.h"

namespace tilecast {

using Quartic = std::array<Twofold, 5>;  // lowest power first

// The ends of the intervals within low .. high in which the quartic is negative, sorted. It is taken to be positive at
// low and high themselves, so the number of ends is even, and at most 4. The low parts are what rounding took: a sum
// that cancels with the high parts keeps its digits.
int negative_between(const Quartic& p, double low, double high, Twofold out[4]);

// A bound on how far the root can move when the quartic's values are off by at most `perturbation`; `most` where they
// cannot tell. To first order perturbation / |slope|, of roots that nearly coincide the square root of perturbation /
// |curvature|; doubled until the other terms of Taylor's series confirm it. (Two roots that near each other may vanish.)
double root_error(const Quartic& p, double root, double perturbation, double most);

}  // namespace tilecast
