// Numbers of each pixel of a tile, channel by channel, and sums over the pixels about each.
#pragma once

#include <memory_resource>
#include <vector>

namespace tilecast {

inline constexpr size_t kChannels = 3;  // of a colour

// Memory that a thread keeps for the next tile: fresh pages cost more than what is reckoned in them.
std::pmr::memory_resource* plane_memory();

struct Planes {
  int height, width;
  size_t pixels, stride;  // from plane to plane: not by a power of two, or all would share a few lines of the cache
  std::pmr::vector<double> values;

  Planes(int h, int w, size_t planes)
      : height(h), width(w), pixels(size_t(h) * w), stride(pixels + 24), values(planes * stride, plane_memory()) {}
  Planes(Planes&&) = default;
  size_t count() const { return values.size() / stride; }
  double* operator[](size_t plane) { return values.data() + plane * stride; }
  const double* operator[](size_t plane) const { return values.data() + plane * stride; }
};

enum class Window : unsigned char { Neighbours, Wide };  // 3 x 3 pixels, 9 x 9

// The sums over a window about each pixel, cut at the tile's edges. Each is summed up on its own: in running sums one
// bright pixel would drown all after it.
Planes window_sums(const Planes& planes, Window window);
// How many pixels those are, one plane.
Planes window_counts(int height, int width, Window window);

Planes window_means(const Planes& planes, const Planes& counts);  // wide ones; counts: theirs

}  // namespace tilecast
