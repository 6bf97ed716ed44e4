// What the squared error of each pixel is divided by, where the true image R is not known: R^2 + 0.01.
//
// What stands for R must not share the pixel's own noise. Samples of light are skewed: a bright one raises a pixel's
// brightness and its estimated variance together, and dividing by the noisy I hides the error of just those pixels that
// have most of it. So R is looked for in three steps, each by the local linear filter of J.-S. Lee (Digital Image
// Enhancement and Noise Filtering by Use of Local Statistics, PAMI 1980): from the mean of a 9 x 9 window without the
// pixel towards the mean of its eight neighbours, and from there towards I, each time by the part of their squared
// difference in the window that noise does not explain. In the last step the pixel's own variance counts as well as the
// window's: where it is an outlier, nothing of I is used. As the variance falls, R becomes I.
//
// The last step can also be taken towards the pixel's mean over a part of the samples: what is found so is independent
// of the variance that the other part tells (Chernozhukov et al., Double/Debiased Machine Learning, 2018: cross-fitting).
//
// What stands for R still has noise, of a variance V that is known. As f(r) = 1 / (r^2 + 0.01) is convex where light is
// not black, f then comes out too large by f'' V / 2, the fraction f (4 r^2 f - 1) V; it is divided by 1 + that. Of V
// only the part counts that is independent of the variance that is weighted: the neighbours', and the pixel's own where
// R was found from another part of the samples.
#pragma once

#include <algorithm>

#include "render/planes.h"

namespace tilecast {

inline constexpr double kErrorFloor = 0.01;  // added to R^2, so that black pixels count

// 1 / (R^2 + 0.01) where R is known as `found`, with noise of that variance.
inline double error_weight(double found, double variance) {
  const double plain = 1.0 / (found * found + kErrorFloor);
  return plain / (1.0 + std::max(plain * (4.0 * found * found * plain - 1.0) * variance, 0.0));
}

// 1 / (R^2 + 0.01) of the pixels of a tile, 3 planes for each 3 of the means and estimated variances that are given. First
// those over all samples; then those over parts of the samples, by each of which R is found anew.
Planes error_weights(const Planes& means, const Planes& variances);

}  // namespace tilecast
