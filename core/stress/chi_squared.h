// Pearson's test of a histogram against the probabilities of its cells, as used for scattering functions by Jakob
// (Mitsuba and Nori): cells in which few samples are expected are pooled.
#pragma once

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace tilecast::stress {

// The probability that a gamma variable of shape a exceeds x: series and continued fraction (Abramowitz and Stegun
// 6.5.29 and 6.5.31, the latter by Lentz's method).
inline double gamma_tail(double a, double x) {
  if (x <= 0.0) return 1.0;
  const double front = std::exp(-x + a * std::log(x) - std::lgamma(a));
  if (x < a + 1.0) {
    double term = 1.0 / a, sum = term;
    for (double n = a + 1.0; std::fabs(term) > 1e-16 * sum; n += 1.0) sum += term *= x / n;
    return 1.0 - sum * front;
  }
  double b = x + 1.0 - a, c = 1e300, d = 1.0 / b, h = d;
  for (int i = 1; i < 10000; ++i) {
    double n = -i * (i - a);
    b += 2.0;
    d = 1.0 / (n * d + b);
    c = b + n / c;
    double step = d * c;
    h *= step;
    if (std::fabs(step - 1.0) < 1e-15) break;
  }
  return front * h;
}

// How likely chance alone makes the counts differ as much from what is expected (both of one length and sum).
inline double p_value(const std::vector<double>& counts, const std::vector<double>& expected) {
  std::vector<size_t> order(counts.size());
  std::iota(order.begin(), order.end(), size_t(0));
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return expected[a] < expected[b]; });
  double statistic = 0.0, pooled_count = 0.0, pooled_expected = 0.0;
  int cells = 0;
  auto take = [&](double count, double mean) {
    statistic += (count - mean) * (count - mean) / mean;
    ++cells;
  };
  for (size_t i : order) {
    if (pooled_expected < 5.0 || expected[i] < 5.0) {
      pooled_count += counts[i], pooled_expected += expected[i];
      continue;
    }
    take(counts[i], expected[i]);
  }
  if (pooled_expected > 0.0) take(pooled_count, pooled_expected);
  return cells < 2 ? 1.0 : gamma_tail(0.5 * (cells - 1), 0.5 * statistic);
}

}  // namespace tilecast::stress
