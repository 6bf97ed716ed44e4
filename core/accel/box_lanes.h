// Boxes that a line is tested against eight at a time.
#pragma once

#include "accel/frame_box.h"
#include "base/lanes.h"

namespace tilecast {

inline constexpr float kNowhere = 1e30f;

struct BoxLanes {
  Float8 lo[3] = {all(kNowhere), all(kNowhere), all(kNowhere)}, hi[3] = {all(kNowhere), all(kNowhere), all(kNowhere)};

  void set(int lane, const FrameBox& box) {
    for (int i = 0; i < 3; ++i) lo[i][lane] = box.lo[i], hi[i][lane] = box.hi[i];
  }
};

// Which boxes the line (a FrameRay or a FloatLine) meets in s_min .. s_max, rounded as clip_to_box does it; `from`: where
// it enters each of them. Lanes that hold no box are for the caller to leave out.
template <class Line>
Mask8 meets(const BoxLanes& boxes, const Line& line, float s_min, float s_max, Float8& from) {
  Float8 to = all(s_max);
  from = all(s_min);
  for (int i = 0; i < 3; ++i) {
    Float8 a = (boxes.lo[i] - line.origin[i]) * line.reciprocal[i];
    Float8 b = (boxes.hi[i] - line.origin[i]) * line.reciprocal[i];
    from = max(from, min(a, b));
    to = min(to, max(a, b));
  }
  return from <= to;
}

}  // namespace tilecast
