#include "render/error_partials.h"

#include <algorithm>
#include <cmath>

#include "render/denominators.h"

namespace tilecast {
namespace {

constexpr double kThird = 1.0 / 3;

// The means of some samples' halves, by three times the pixel plus the channel.
struct Halves {
  const double *even, *odd;
  double to_a, to_b;

  Halves(const SampleSums& of, size_t pixels)
      : even(of.sums), odd(even + kChannels * pixels), to_a(1.0 / ((of.samples + 1) / 2)), to_b(1.0 / (of.samples / 2)) {}
  double a(size_t at) const { return even[at] * to_a; }
  double b(size_t at) const { return odd[at] * to_b; }
};

// The mean of all, and v, which estimates its variance, into the three planes from `first` on.
void moments(const SampleSums& of, Planes& means, Planes& variances, size_t first) {
  const Halves halves(of, means.pixels);
  const double n_a = (of.samples + 1) / 2, n_b = of.samples / 2, n = of.samples;
  const double to_mean = 1.0 / n, share = n_a * n_b / (n * n);
  for (size_t i = 0, at = 0; i < means.pixels; ++i)
    for (size_t c = 0; c < kChannels; ++c, ++at) {
      const double off = halves.a(at) - halves.b(at);
      means[first + c][i] = (halves.even[at] + halves.odd[at]) * to_mean;
      variances[first + c][i] = off * off * share;
    }
}

// Of the variance of the difference of two parts' means, what the mean over both has: of a half of `first` and of `last`
// samples, the even ones with `odd` = 1 (they are one more where the number is odd), the odd ones with 0.
double half_share(int first, int last, int odd) {
  const double n = (first + odd) / 2, m = (last + odd) / 2;
  return n * m / ((n + m) * (n + m));
}

}  // namespace

ErrorPartials error_partials(int height, int width, const SampleSums& all, const std::optional<SampleParts>& parts,
                             const std::optional<ErrorPartials>& previous) {
  const bool split = parts && std::min(parts->first.samples, parts->last.samples) >= 2;
  const size_t planes = kChannels * (split ? 3 : 1);
  Planes means(height, width, planes), variances(height, width, planes);
  moments(all, means, variances, 0);
  const size_t pixels = means.pixels;
  ErrorPartials out = previous.value_or(ErrorPartials{});
  for (int at : {0, 3, 9, 10}) out[at] = 0.0;

  if (!split) {
    const Planes weights = error_weights(means, variances);
    for (size_t i = 0; i < pixels; ++i) {
      double v = 0.0, relative = 0.0;
      for (size_t c = 0; c < kChannels; ++c) {
        v += variances[c][i] * kThird;
        relative += variances[c][i] * weights[c][i] * kThird;
      }
      out[0] += v;
      out[3] += relative;
      out[9] += v * v;
      out[10] += relative * relative;
    }
    if (!previous) {
      out[1] = 4.0 / 3 * out[9];
      out[2] = out[0];
      out[4] = 4.0 / 3 * out[10];
      out[5] = out[3];
    }
  } else {
    const int first = parts->first.samples, last = parts->last.samples;
    moments(parts->first, means, variances, kChannels);
    moments(parts->last, means, variances, 2 * kChannels);
    const Halves before(parts->first, pixels), in(parts->last, pixels);
    const Planes weights = error_weights(means, variances);
    const double to_a = half_share(first, last, 1), to_b = half_share(first, last, 0);
    const double to_both = std::sqrt(to_a * to_b) * kThird;
    // Scaled by their samples, so that both estimate the variance of the whole.
    const double of_first = double(first) / all.samples, of_last = double(last) / all.samples;
    Planes tails(height, width, 2);  // as the first part tells them, and the last
    std::fill_n(out.begin() + 1, 2, 0.0);
    std::fill_n(out.begin() + 4, 4, 0.0);
    for (size_t i = 0; i < pixels; ++i) {
      double product = 0.0, relative_product = 0.0, all_channels = 0.0, relative = 0.0;
      for (size_t c = 0; c < kChannels; ++c) {
        const double v = variances[c][i], v_first = variances[3 + c][i], v_last = variances[6 + c][i];
        const double weight = weights[c][i], by_first = weights[3 + c][i], by_last = weights[6 + c][i];
        const size_t at = i * kChannels + c;
        const double a = before.a(at) - in.a(at), b = before.b(at) - in.b(at);
        const double square = a * a * to_a + b * b * to_b, both = a * b * to_both;
        const double crossed = 0.5 * (by_first + by_last);
        all_channels += v;
        relative += v * weight;
        out[2] += square;
        out[5] += square * crossed;
        out[6] += v_first * by_last + v_last * by_first;
        out[7] += (v_first + v_last) * weight;
        product += both;
        relative_product += both * crossed;
        tails[0][i] += v_first * weight;
        tails[1][i] += v_last * weight;
      }
      all_channels *= kThird;
      relative *= kThird;
      out[0] += all_channels;
      out[1] += product * product;
      out[3] += relative;
      out[4] += relative_product * relative_product;
      out[9] += all_channels * all_channels;
      out[10] += relative * relative;
      tails[0][i] *= of_first * kThird;
      tails[1][i] *= of_last * kThird;
    }
    for (int at : {2, 5}) out[at] *= kThird / 4;
    for (int at : {6, 7}) out[at] *= kThird * of_first * of_last;
    const TailPartials histograms = tail_partials({tails[0], pixels}, {tails[1], pixels});
    std::copy(histograms.begin(), histograms.end(), out.begin() + kErrorSums);
  }
  out[8] = out[3] / std::sqrt(double(all.samples));
  return out;
}

}  // namespace tilecast
