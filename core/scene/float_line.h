// A line rounded to float in a frame. Boxes that it is tested against (accel/box_lanes.h) are padded by kRoom beside
// kBoxPadding: what float loses here is far less.
#pragma once

#include "accel/box_lanes.h"

namespace tilecast {

inline constexpr double kRoom = 0x1p-12;  // frame units: what is nearer to an end of the range is not left out

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

}  // namespace tilecast
