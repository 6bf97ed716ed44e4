// Monte Carlo estimates with their standard errors, and the chi-squared test.
#pragma once

#include <gtest/gtest.h>

#include "render/chunk.h"

namespace tilecast {

struct Estimate {
  double mean, error;  // error: one standard deviation of the mean
};

// Of the first channel, from the pixels of the whole image, which are independent of each other.
inline Estimate estimate(const Scene& scene, uint32_t samples) {
  const int width = scene.camera.width(), height = scene.camera.height(), n = width * height;
  ChunkSums chunk = render_chunk(scene, {0, 0, width, height}, 0, samples);
  double sum = 0.0, squares = 0.0;
  for (int i = 0; i < n; ++i) {
    const double value = (chunk.sums[3 * i] + chunk.sums[3 * (n + i)]) / samples;
    sum += value, squares += value * value;
  }
  const double mean = sum / n;
  return {mean, std::sqrt(std::max(0.0, squares / n - mean * mean) / (n - 1))};
}

// Within 4.5 standard errors (7 in a million are not, by chance) and rounding.
inline void expect_near(const Estimate& found, double exact) {
  EXPECT_NEAR(found.mean, exact, 4.5 * found.error + 1e-9 * std::fabs(exact));
}
inline void expect_same(const Estimate& a, const Estimate& b) {
  EXPECT_NEAR(a.mean, b.mean, 4.5 * std::hypot(a.error, b.error) + 1e-9 * std::fabs(a.mean));
}

// Whether counts are what was expected, by Pearson's test at a level of 1e-5: Wilson and Hilferty's approximation of the
// distribution, which is good to a few parts in a thousand. Cells with few expected are pooled.
inline void expect_distributed(const std::vector<double>& counts, const std::vector<double>& expected) {
  double statistic = 0.0, pooled = 0.0, pooled_expected = 0.0;
  int cells = 0;
  auto add = [&](double count, double mean) {
    statistic += (count - mean) * (count - mean) / mean;
    ++cells;
  };
  for (size_t i = 0; i < counts.size(); ++i) {
    if (expected[i] == 0.0) {
      EXPECT_EQ(counts[i], 0.0) << i;
    }
    if (expected[i] >= 10.0) add(counts[i], expected[i]);
    else pooled += counts[i], pooled_expected += expected[i];
  }
  if (pooled_expected >= 10.0) add(pooled, pooled_expected);
  const double k = cells - 1, spread = 2.0 / (9.0 * k);
  EXPECT_LT((std::cbrt(statistic / k) - (1.0 - spread)) / std::sqrt(spread), 4.26) << statistic << " with " << k;
}

}  // namespace tilecast
