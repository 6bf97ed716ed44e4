#include "render/planes.h"

#include <algorithm>

namespace tilecast {

std::pmr::memory_resource* plane_memory() {
  thread_local std::pmr::unsynchronized_pool_resource pool({.max_blocks_per_chunk = 1, .largest_required_pool_block = 1 << 24});
  return &pool;
}

namespace {

// Unrolled, so that a window's pixels are added up in registers.
template <int kRadius>
Planes sums_within(const Planes& planes) {
  constexpr int kSide = 2 * kRadius + 1;
  const int height = planes.height, width = planes.width;
  Planes out(height, width, planes.count());
  const Planes nothing(1, width, 1);
  Planes padded(1, width + 2 * kRadius, 1);  // a row of sums over columns, with zeros either side
  double* const row = padded[0];
  for (size_t plane = 0; plane < planes.count(); ++plane)
    for (int y = 0; y < height; ++y) {
      const double* rows[kSide];
      for (int k = 0; k < kSide; ++k) {
        const int at = y - kRadius + k;
        rows[k] = at >= 0 && at < height ? planes[plane] + size_t(at) * width : nothing[0];
      }
      for (int x = 0; x < width; ++x) {
        double sum = rows[0][x];
        for (int k = 1; k < kSide; ++k) sum += rows[k][x];
        row[kRadius + x] = sum;
      }
      double* const to = out[plane] + size_t(y) * width;
      for (int x = 0; x < width; ++x) {
        double sum = row[x];
        for (int k = 1; k < kSide; ++k) sum += row[x + k];
        to[x] = sum;
      }
    }
  return out;
}

}  // namespace

Planes window_sums(const Planes& planes, Window window) {
  return window == Window::Neighbours ? sums_within<1>(planes) : sums_within<4>(planes);
}

Planes window_counts(int height, int width, Window window) {
  Planes ones(height, width, 1);
  std::fill(ones.values.begin(), ones.values.end(), 1.0);
  return window_sums(ones, window);
}

Planes window_means(const Planes& planes, const Planes& counts) {
  Planes out = window_sums(planes, Window::Wide);
  for (size_t plane = 0; plane < out.count(); ++plane)
    for (size_t i = 0; i < out.pixels; ++i) out[plane][i] /= counts[0][i];
  return out;
}

}  // namespace tilecast
