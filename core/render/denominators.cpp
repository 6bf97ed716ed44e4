#include "render/denominators.h"

#include <algorithm>

namespace tilecast {
namespace {

constexpr double kCaution = 1.5;  // times the noise: what the neighbours must differ by from the window to be structure
constexpr double kNear = 1.0 / 8, kWide = 1.0 / 80;  // of a pixel's noise: that of its neighbours' mean, of its window's

double square(double x) { return x * x; }

// The means over windows without the pixels themselves; a single pixel's is 0.
Planes without_centre(const Planes& planes, Window window, const Planes& counts) {
  Planes out = window_sums(planes, window);
  for (size_t plane = 0; plane < out.count(); ++plane)
    for (size_t i = 0; i < out.pixels; ++i)
      out[plane][i] = (out[plane][i] - planes[plane][i]) / std::max(counts[0][i] - 1.0, 1.0);
  return out;
}

// The part of the square of `off` in each window that `noise` does not explain, one for all channels: a plane for each
// three of `off` and each of `noise`.
Planes gain(const Planes& off, const Planes& noise, const Planes& counts) {
  Planes squares(off.height, off.width, noise.count());
  for (size_t plane = 0; plane < off.count(); ++plane)
    for (size_t i = 0; i < off.pixels; ++i) squares[plane / kChannels][i] += square(off[plane][i]);
  Planes out = window_means(squares, counts);
  for (size_t i = 0; i < out.values.size(); ++i) {
    const double total = out.values[i];
    out.values[i] = total > 0.0 ? std::max(total - noise.values[i], 0.0) / total : 0.0;
  }
  return out;
}

}  // namespace

Planes error_weights(const Planes& means, const Planes& variances) {
  const size_t parts = means.count() / kChannels, pixels = means.pixels;
  const int height = means.height, width = means.width;
  const auto planes = [&](size_t count) { return Planes(height, width, count); };

  const Planes counts = window_counts(height, width, Window::Wide), around = window_means(variances, counts);
  Planes whole = planes(kChannels), noise = planes(1);
  std::copy_n(means[0], whole.values.size(), whole[0]);
  for (size_t c = 0; c < kChannels; ++c)
    for (size_t i = 0; i < pixels; ++i) noise[0][i] += around[c][i];

  // From the window towards the neighbours, which are 8 of the window's 80.
  const Planes wide = without_centre(whole, Window::Wide, counts);
  const Planes near = without_centre(whole, Window::Neighbours, window_counts(height, width, Window::Neighbours));
  Planes step = planes(kChannels), step_noise = planes(1);
  for (size_t i = 0; i < step.values.size(); ++i) step.values[i] = near.values[i] - wide.values[i];
  for (size_t i = 0; i < pixels; ++i) step_noise[0][i] = kCaution * (kNear - kWide) * noise[0][i];
  const Planes nearer = gain(step, step_noise, counts);
  Planes local = planes(kChannels), local_variance = planes(kChannels);
  for (size_t c = 0; c < kChannels; ++c)
    for (size_t i = 0; i < pixels; ++i) {
      local[c][i] = wide[c][i] + nearer[0][i] * step[c][i];
      const double others = counts[0][i] - 1.0;
      local_variance[c][i] = (around[c][i] * counts[0][i] - variances[c][i]) / std::max(others, 1.0) *
                             (kWide + nearer[0][i] * (kNear - kWide));
    }

  // From there towards the pixel itself, as each part of the samples has it.
  Planes off = planes(means.count()), off_noise = planes(parts);
  for (size_t k = 0; k < parts; ++k)
    for (size_t i = 0; i < pixels; ++i) {
      double own = 0.0, windows = 0.0;
      for (size_t c = 0; c < kChannels; ++c) {
        const size_t plane = k * kChannels + c;
        off[plane][i] = means[plane][i] - local[c][i];
        own += variances[plane][i];
        windows += around[plane][i];
      }
      off_noise[k][i] = std::max(own, windows) + kNear * noise[0][i];
    }
  const Planes own = gain(off, off_noise, counts);

  Planes out = planes(means.count());
  for (size_t plane = 0; plane < out.count(); ++plane) {
    const size_t k = plane / kChannels, c = plane % kChannels;
    for (size_t i = 0; i < pixels; ++i) {
      const double found = local[c][i] + own[k][i] * off[plane][i];
      double left = local_variance[c][i] * square(1.0 - own[k][i]);
      if (k > 0) left += square(own[k][i]) * around[plane][i];
      out[plane][i] = error_weight(found, left);
    }
  }
  return out;
}

}  // namespace tilecast
