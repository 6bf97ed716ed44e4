// Eight rays side by side, in double as one by one, and their lines rounded to float in a frame (scene/float_line.h).
#pragma once

#include "geometry/sure_lanes.h"
#include "scene/object.h"

namespace tilecast {

// What a frame asks of directions, whatever it is the frame of; see NearLine.
struct DirectionLanes {
  Double8 unit[3], per_square, shrink, stretch;  // unit: times shrink, a power of two, the largest component in [1, 2)
  Float8 direction[3], reciprocal[3], inverse_square;
  uint32_t usable;  // one bit a lane

  explicit DirectionLanes(const Double8 (&d)[3]) {
    const Double8 largest = max(max(abs(d[0]), abs(d[1])), abs(d[2]));
    usable = bits((largest >= 0x1p-1000) & (largest <= 0x1p1000));
    shrink = power_below_reciprocal(largest), stretch = power_below(largest);
    for (int i = 0; i < 3; ++i) {
      unit[i] = d[i] * shrink;
      direction[i] = to_float(unit[i]);
      const Float8 flat = (Float8)(((Mask8)direction[i] & INT32_MIN) | (Mask8)all(0x1p-40f));
      const Float8 size = (Float8)((Mask8)direction[i] & INT32_MAX);
      reciprocal[i] = 1.0f / (size < 0x1p-40f ? flat : direction[i]);
    }
    const Double8 square = unit[0] * unit[0] + unit[1] * unit[1] + unit[2] * unit[2];
    per_square = Double8(1.0) / square;
    inverse_square = to_float(per_square);
  }
};

// In the space of an object. The parts that stay the same from space to space are pointed to.
struct RayLanes {
  LineLanes line;
  const DirectionLanes* directions;

  Ray ray(int lane, double t_min, double t_max) const {
    Ray ray = line.line(lane);
    ray.t_min = t_min, ray.t_max = t_max;
    return ray;
  }
};

// In an instance's space, as Instance::local does it.
inline void bring(const Instance& instance, const LineLanes& from, LineLanes& to) {
  Double8 offset[3];
  for (int i = 0; i < 3; ++i) offset[i] = from.origin[i] - instance.to_local.origin[i];
  if (!instance.turned) {
    for (int i = 0; i < 3; ++i) to.origin[i] = offset[i], to.direction[i] = from.direction[i];
    return;
  }
  const glm::dmat3& m = instance.to_local.linear;
  auto row = [&](const Double8 (&v)[3], int i) {
    return fma(m[0][i], v[0], fma(m[1][i], v[1], fma(m[2][i], v[2], 0.0)));
  };
  for (int i = 0; i < 3; ++i) to.origin[i] = row(offset, i), to.direction[i] = row(from.direction, i);
}

struct FloatLines {
  Float8 origin[3];
  const DirectionLanes* directions;
  Double8 start, scale, per_t;
  Double8 farthest;  // of the origins, frame units

  // Which of them come near the frame's content.
  uint32_t enter(const Frame& frame, const RayLanes& rays) {
    directions = rays.directions;
    const auto& unit = directions->unit;
    Double8 from[3], near[3];
    for (int i = 0; i < 3; ++i) from[i] = (rays.line.origin[i] - frame.centre[i]) * frame.per_metre;
    farthest = max(max(abs(from[0]), abs(from[1])), abs(from[2]));
    start = -(from[0] * unit[0] + from[1] * unit[1] + from[2] * unit[2]) * directions->per_square;
    for (int i = 0; i < 3; ++i) {
      near[i] = from[i] + start * unit[i];
      origin[i] = to_float(near[i]);
    }
    scale = directions->shrink * frame.scale, per_t = directions->stretch * frame.per_metre;
    return directions->usable & bits(near[0] * near[0] + near[1] * near[1] + near[2] * near[2] <= 4.0);
  }

  Float8 s(const Double8& t) const { return to_float(t * per_t - start); }
  // With room for what float loses.
  Float8 room() const { return static_cast<float>(kRoom) + to_float(abs(start)) * 0x1p-50f; }
  static Float8 loss(Float8 s) { return (Float8)((Mask8)s & INT32_MAX) * 0x1p-22f; }
  Float8 s_below(const Double8& t) const {
    const Float8 at = s(t);
    return at - loss(at) - room();
  }
  Float8 s_above(const Double8& t) const {
    const Float8 at = s(t);
    return at + loss(at) + room();
  }
};

// Which lines meet one box within s_min .. s_max, which it narrows.
inline Mask8 clip_to_box(const float (&lo)[3], const float (&hi)[3], const FloatLines& lines, Float8& s_min, Float8& s_max) {
  for (int i = 0; i < 3; ++i) {
    const Float8 per = lines.directions->reciprocal[i];
    const Float8 a = (lo[i] - lines.origin[i]) * per, b = (hi[i] - lines.origin[i]) * per;
    s_min = max(s_min, min(a, b));
    s_max = min(s_max, max(a, b));
  }
  return s_min <= s_max;
}

}  // namespace tilecast
