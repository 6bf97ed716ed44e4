// What a tile contributes to the estimate of an image's error at a checkpoint: sums over its pixels. What they stand for
// and what follows from them says server/tilecast/render/error.py.
#pragma once

#include <optional>

#include "render/planes.h"
#include "render/tails.h"

namespace tilecast {

// Of the squared error and of the relative one: v, and as its parts tell it (a . b)^2 and (a^2 + b^2) / 4; then the
// relative one with R from other samples, from the same, and over sqrt(n); and v^2 of both.
inline constexpr int kErrorSums = 11;
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
