// What a hierarchy is built of: a primitive's box and number in one vector of eight floats, so that they move together
// and boxes are joined by one minimum.
#pragma once

#include <bit>

#include "accel/frame_box.h"

namespace tilecast {

using Four [[gnu::vector_size(16)]] = float;
using Eight [[gnu::vector_size(32)]] = float;
using Four32 [[gnu::vector_size(16)]] = int32_t;
using Eight32 [[gnu::vector_size(32)]] = int32_t;

constexpr float kFar = FrameBox::kFar;
constexpr Eight kNothing = {kFar, kFar, kFar, kFar, kFar, kFar, kFar, kFar};

inline Eight least(Eight a, Eight b) { return a < b ? a : b; }
inline Four low_half(Eight v) { return __builtin_shufflevector(v, v, 0, 1, 2, 3); }
inline Four high_half(Eight v) { return __builtin_shufflevector(v, v, 4, 5, 6, 7); }

struct BuildItem {  // 32 bytes
  Eight lanes;      // lo, kNumber | the primitive's number; -hi, 0

  static constexpr uint32_t kNumber = 1u << 30;  // numbers alone would be denormal floats, which are slow to subtract

  static BuildItem of(const FrameBox& box, uint32_t primitive) {
    return {Eight{box.lo[0], box.lo[1], box.lo[2], std::bit_cast<float>(kNumber | primitive),  //
                  -box.hi[0], -box.hi[1], -box.hi[2], 0.0f}};
  }
  uint32_t primitive() const { return static_cast<uint32_t>(std::bit_cast<Eight32>(lanes)[3]) & ~kNumber; }
  // Twice the box's centre, and its negative: as a box, a point. The fourth lanes mean nothing.
  Eight centre() const { return lanes - __builtin_shufflevector(lanes, lanes, 4, 5, 6, 7, 0, 1, 2, 3); }
};

// Of joined lanes.
inline FrameBox box_of(Eight v) { return {{v[0], v[1], v[2]}, {-v[4], -v[5], -v[6]}}; }

// Half the surfaces of three boxes, in the first three lanes. Of nothing: infinite.
inline Four half_areas(Eight a, Eight b, Eight c) {
  auto extent = [](Eight v) { return -(low_half(v) + high_half(v)); };
  const Four d = extent(a), e = extent(b), f = extent(c);
  const Four xy = __builtin_shufflevector(d, e, 0, 4, 1, 5), z = __builtin_shufflevector(d, e, 2, 6, 3, 7);
  const Four x3 = __builtin_shufflevector(xy, f, 0, 1, 4, 4), y3 = __builtin_shufflevector(xy, f, 2, 3, 5, 5),
             z3 = __builtin_shufflevector(z, f, 0, 1, 6, 6);
  return x3 * y3 + y3 * z3 + z3 * x3;
}

}  // namespace tilecast
