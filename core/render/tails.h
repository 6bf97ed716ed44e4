// Whether a tile's error comes from a few rare events: histograms over the logarithm of two estimates of each pixel's
// error, which simply add up over tiles. What follows from them is the business of the image's estimate.
#pragma once

#include <array>
#include <span>

namespace tilecast {

inline constexpr int kTailBins = 24;  // powers of 4 from the lowest on, for errors relative to the image

// For each of a and b, the other beside it: pixels, their sum, and the sum of the other, by bin.
using TailPartials = std::array<double, 6 * kTailBins>;

TailPartials tail_partials(std::span<const double> a, std::span<const double> b);

}  // namespace tilecast
