// What a tile contributes to the estimate of an image's error at a checkpoint: sums over its pixels. What they stand for
// and what follows from them says server/tilecast/render/error.py.
#pragma once

#include <optional>

#include "render/planes.h"
#include "render/tails.h"

namespace tilecast {

// Sums over pixels, of the squared error and again of the relative one. Of a pixel: v, and v^2; what stands for v^2 / 3 by
// two parts of the samples; p, the product of what they tell of it, and the root of the sum of p^2.
enum { kV, kVSquares, kFourths, kP, kPSquares, kSumsOfKind };
// Then the relative error with R from other samples, from the same, and over sqrt(n).
enum { kFromOthers = 2 * kSumsOfKind, kFromSame, kBySamples, kErrorSums };
using ErrorPartials = std::array<double, kErrorSums + std::tuple_size_v<TailPartials>>;

struct SampleSums {
  const double* sums;  // [2, height, width, 3]: even and odd samples apart
  int samples;         // of each pixel, at least 2
};
struct SampleParts {
  SampleSums first, last;  // those before the last range and those in it
};

// `previous`: of the checkpoint before, from which what parts would tell is taken where one has a single sample.
ErrorPartials error_partials(int height, int width, const SampleSums& all, const std::optional<SampleParts>& parts,
                             const std::optional<ErrorPartials>& previous);

}  // namespace tilecast
