#include "render/error_partials.h"

#include <algorithm>
#include <cmath>

#include "render/denominators.h"

namespace tilecast {
namespace {

constexpr double kThird = 1.0 / 3;

// Some samples' halves, by three times the pixel plus the channel.
struct Halves {
  const double *even, *odd;
  double to_even, to_odd;  // from sums to means

  Halves(const SampleSums& of, size_t pixels)
      : even(of.sums), odd(even + kChannels * pixels), to_even(1.0 / ((of.samples + 1) / 2)), to_odd(1.0 / (of.samples / 2)) {}
  double off(size_t at) const { return even[at] * to_even - odd[at] * to_odd; }
};

// What the square of the halves' difference is multiplied by to tell the variance of their mean.
double to_variance(int samples) {
  const double even = (samples + 1) / 2, odd = samples / 2;
  return even * odd / (double(samples) * samples);
}

// The mean of all, and v, which estimates its variance, into the three planes from `first` on.
void moments(const SampleSums& of, Planes& means, Planes& variances, size_t first) {
  const Halves halves(of, means.pixels);
  const double to_mean = 1.0 / of.samples, to_v = to_variance(of.samples);
  for (size_t i = 0, at = 0; i < means.pixels; ++i)
    for (size_t c = 0; c < kChannels; ++c, ++at) {
      const double off = halves.off(at);
      means[first + c][i] = (halves.even[at] + halves.odd[at]) * to_mean;
      variances[first + c][i] = off * off * to_v;
    }
}

// The root of a sum of squares that cannot overflow (Lawson et al., Basic Linear Algebra Subprograms, 1979).
class RootOfSquares {
 public:
  void add(double x) {
    if (x > largest_) {
      sum_ *= (largest_ / x) * (largest_ / x);
      largest_ = x;
    }
    if (x > 0.0) sum_ += (x / largest_) * (x / largest_);
  }
  double value() const { return largest_ * std::sqrt(sum_); }

 private:
  double largest_ = 0.0, sum_ = 0.0;  // of the squares of x / largest
};

// The sums of one kind of error, by pixels.
class Told {
 public:
  explicit Told(double* out) : out_(out) {}

  void add(double v) {
    out_[kV] += v;
    out_[kVSquares] += v * v;
  }
  // d^2 of the first part, of the last, and of both: what each tells of the whole. `fourths`: see `fourth_powers`.
  void add_parts(double first, double last, double both, double fourths) {
    add_product(4 * both * both,
                fourths * (first * first + last * last) + (kThird - 2 * fourths) * (first * last + 2 * both * both));
  }
  // Where there are no parts, as if noise were normal and of one colour.
  void add_normal(double v) { add_product(4 * kThird * v * v, kThird * v * v); }
  void finish() { out_[kPSquares] = squares_.value(); }

 private:
  void add_product(double p, double fourths) {
    out_[kP] += p;
    out_[kFourths] += fourths;
    squares_.add(p);
  }

  double* out_;
  RootOfSquares squares_;
};

// How much the fourth powers of parts of so many samples count beside their products, so that together they have the excess
// of v^2 / 3 over that of normal noise: a mean's fourth cumulant is as much smaller as its samples are more, cubed.
double fourth_powers(double first, double last) { return first * last / (3.0 * (first + last) * (first + last)); }

}  // namespace

ErrorPartials error_partials(int height, int width, const SampleSums& all, const std::optional<SampleParts>& parts,
                             const std::optional<ErrorPartials>& previous) {
  const bool split = parts && std::min(parts->first.samples, parts->last.samples) >= 2;
  const size_t planes = kChannels * (split ? 3 : 1);
  Planes means(height, width, planes), variances(height, width, planes);
  moments(all, means, variances, 0);
  if (split) {
    moments(parts->first, means, variances, kChannels);
    moments(parts->last, means, variances, 2 * kChannels);
  }
  const size_t pixels = means.pixels;
  const Planes weights = error_weights(means, variances);
  ErrorPartials out = previous.value_or(ErrorPartials{});
  const bool told_anew = split || !previous;  // or what parts told at the checkpoint before stays
  for (int kind : {0, 1}) std::fill_n(&out[kind * kSumsOfKind], told_anew ? kSumsOfKind : kFourths, 0.0);
  Told squared(&out[0]), relative(&out[kSumsOfKind]);

  for (size_t i = 0; i < pixels; ++i) {
    double v = 0.0, v_relative = 0.0;
    for (size_t c = 0; c < kChannels; ++c) {
      v += variances[c][i] * kThird;
      v_relative += variances[c][i] * weights[c][i] * kThird;
    }
    squared.add(v);
    relative.add(v_relative);
    if (told_anew && !split) {
      squared.add_normal(v);
      relative.add_normal(v_relative);
    }
  }
  if (split) {
    const int first = parts->first.samples, last = parts->last.samples;
    const Halves before(parts->first, pixels), in(parts->last, pixels);
    // Scaled by their samples, so that both estimate the variance of the whole.
    const double of_first = double(first) / all.samples, of_last = double(last) / all.samples;
    const double to_first = of_first * kThird, to_last = of_last * kThird;
    const double to_both = std::sqrt(to_first * to_variance(first) * to_last * to_variance(last));
    const double fourths = fourth_powers(first, last);
    Planes tails(height, width, 2);  // as the first part tells them, and the last
    double others = 0.0, same = 0.0;
    for (size_t i = 0; i < pixels; ++i) {
      double told[3] = {}, told_relative[3] = {};  // by the first, the last, both
      for (size_t c = 0; c < kChannels; ++c) {
        const double v_first = variances[3 + c][i], v_last = variances[6 + c][i];
        const double weight = weights[c][i], by_first = weights[3 + c][i], by_last = weights[6 + c][i];
        const size_t at = i * kChannels + c;
        const double by_parts[3] = {v_first * to_first, v_last * to_last, before.off(at) * in.off(at) * to_both};
        for (int k = 0; k < 3; ++k) {
          told[k] += by_parts[k];
          told_relative[k] += by_parts[k] * (by_first + by_last) * 0.5;
        }
        others += v_first * by_last + v_last * by_first;
        same += (v_first + v_last) * weight;
        tails[0][i] += v_first * to_first * weight;
        tails[1][i] += v_last * to_last * weight;
      }
      squared.add_parts(told[0], told[1], told[2], fourths);
      relative.add_parts(told_relative[0], told_relative[1], told_relative[2], fourths);
    }
    out[kFromOthers] = others * kThird * of_first * of_last;
    out[kFromSame] = same * kThird * of_first * of_last;
    const TailPartials histograms = tail_partials({tails[0], pixels}, {tails[1], pixels});
    std::copy(histograms.begin(), histograms.end(), out.begin() + kErrorSums);
  }
  if (told_anew) {
    squared.finish();
    relative.finish();
  }
  out[kBySamples] = out[kSumsOfKind + kV] / std::sqrt(double(all.samples));
  return out;
}

}  // namespace tilecast
