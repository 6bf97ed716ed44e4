#include "accel/ray_order.h"

#include <array>
#include <bit>

namespace tilecast {
namespace {

constexpr size_t kFew = 2048;
constexpr int kBits = 7;  // of each axis of the origin, in the key

constexpr auto kSpread = [] {  // bit i to bit 3 i
  std::array<uint32_t, 1 << kBits> table{};
  for (uint32_t x = 0; x < table.size(); ++x)
    for (int bit = 0; bit < kBits; ++bit) table[x] |= (x >> bit & 1) << 3 * bit;
  return table;
}();

// Along a space-filling curve through the frame by origin, then by the direction's octant.
uint32_t key(const Frame& frame, double per_unit, const Ray& ray) {
  const double *origin = &ray.origin.x, *direction = &ray.direction.x, *centre = &frame.centre.x;
  uint32_t key = 0;
  for (int i = 0; i < 3; ++i) {
    const double place = (origin[i] - centre[i]) * per_unit + 0.5 * (1 << kBits);
    const int cell = static_cast<int>(std::min((1 << kBits) - 1.0, std::max(0.0, place)));  // not a number: 0
    key |= kSpread[cell] << (3 + i) | static_cast<uint32_t>(std::bit_cast<uint64_t>(direction[i]) >> 63) << i;
  }
  return key;
}

// Whether most rays are in the same cell as the one before.
bool in_order(const Frame& frame, double per_unit, std::span<const Ray> rays) {
  size_t alike = 0, looked_at = 0;
  for (size_t i = 1; i < rays.size(); i += 31, ++looked_at) {
    uint32_t differing = key(frame, per_unit, rays[i - 1]) ^ key(frame, per_unit, rays[i]);
    alike += differing >> 9 == 0;  // a cell of a quarter of the resolution
  }
  return 2 * alike >= looked_at;
}

}  // namespace

std::vector<uint32_t> order_for_cache(const Frame& frame, std::span<const Ray> rays) {
  const double per_unit = 0.5 * (1 << kBits) / frame.scale;
  if (rays.size() < kFew || in_order(frame, per_unit, rays)) return {};
  // Radix sort, 12 bits at a time.
  constexpr int kDigits = 12, kPasses = 2;
  static_assert(3 * kBits + 3 <= kDigits * kPasses);
  std::vector<uint32_t> keys(rays.size()), order(rays.size()), next_keys(rays.size()), next(rays.size());
  std::vector<uint32_t> starts(kPasses << kDigits);
  constexpr uint32_t kMask = (1u << kDigits) - 1;
  for (size_t i = 0; i < rays.size(); ++i) {
    keys[i] = key(frame, per_unit, rays[i]);
    order[i] = static_cast<uint32_t>(i);
    for (int pass = 0; pass < kPasses; ++pass) ++starts[(pass << kDigits) + (keys[i] >> pass * kDigits & kMask)];
  }
  for (int pass = 0; pass < kPasses; ++pass) {
    uint32_t* start = &starts[pass << kDigits];
    for (uint32_t sum = 0, i = 0; i <= kMask; ++i) {
      uint32_t count = start[i];
      start[i] = sum;
      sum += count;
    }
    for (size_t i = 0; i < rays.size(); ++i) {
      uint32_t to = start[keys[i] >> pass * kDigits & kMask]++;
      next_keys[to] = keys[i], next[to] = order[i];
    }
    keys.swap(next_keys), order.swap(next);
  }
  return order;
}

}  // namespace tilecast
