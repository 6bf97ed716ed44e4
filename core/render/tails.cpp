#include "render/tails.h"

#include <algorithm>
#include <cmath>

namespace tilecast {
namespace {

constexpr int kLowest = -16;  // of powers of 4; what is smaller counts in the first bin, what is larger in the last

// Bin e - kLowest holds 4^e / 2 <= value < 4^e * 2.
int bin_of(double value) {
  if (!(value > 0.0)) return 0;
  int exponent = 0;
  std::frexp(std::min(value, 1e300), &exponent);
  return std::clamp((exponent >> 1) - kLowest, 0, kTailBins - 1);
}

void add(double value, double other, double* histogram) {
  const int at = bin_of(value);
  histogram[at] += 1.0;
  histogram[kTailBins + at] += value;
  histogram[2 * kTailBins + at] += other;
}

}  // namespace

TailPartials tail_partials(std::span<const double> a, std::span<const double> b) {
  TailPartials out{};
  for (size_t i = 0; i < a.size(); ++i) {
    add(a[i], b[i], out.data());
    add(b[i], a[i], out.data() + 3 * kTailBins);
  }
  return out;
}

}  // namespace tilecast
