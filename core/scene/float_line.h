// A line rounded to float in a frame, and boxes that it is tested against eight at a time.
//
// Boxes are padded by kRoom beside kBoxPadding: what float loses here is far less.
#pragma once

#include "accel/frame_box.h"
#include "base/lanes.h"

namespace tilecast {

inline constexpr double kRoom = 0x1p-12;  // frame units: what is nearer to an end of the range is not left out
inline constexpr float kNowhere = 1e30f;

// t of the ray = (start + s) * scale; s counts from the point closest to the frame's centre.
struct FloatLine {
  float origin[3], direction[3], reciprocal[3];
  double start, scale, per_t;  // scale = 1 / per_t, powers of two
  double farthest;             // the origin of the ray, frame units

  double t(float s) const { return (start + s) * scale; }
  float s(double t) const { return static_cast<float>(t * per_t - start); }
};

// False where the line passes the frame's content by, or is not finite.
inline bool enter_line(const Frame& frame, const Ray& ray, FloatLine& out) {
  NearLine line;
  if (!enter_near(frame, ray, line)) return false;
  out.scale = line.t_scale, out.per_t = line.s_scale, out.start = line.t_start;
  out.farthest = max_abs(line.origin);
  for (int i = 0; i < 3; ++i) {
    out.origin[i] = static_cast<float>(line.start[i]);
    out.direction[i] = static_cast<float>(line.direction[i]);
    out.reciprocal[i] = slab_reciprocal(out.direction[i]);
  }
  return true;
}

struct BoxLanes {
  Float8 lo[3] = {all(kNowhere), all(kNowhere), all(kNowhere)}, hi[3] = {all(kNowhere), all(kNowhere), all(kNowhere)};

  void set(int lane, const FrameBox& box) {
    FrameBox padded = box.padded(static_cast<float>(kRoom));
    for (int i = 0; i < 3; ++i) lo[i][lane] = padded.lo[i], hi[i][lane] = padded.hi[i];
  }
};

// Which boxes the line meets in s_min .. s_max; `from`: where it enters each of them.
inline Mask8 meets(const BoxLanes& boxes, const FloatLine& line, float s_min, float s_max, Float8& from) {
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
