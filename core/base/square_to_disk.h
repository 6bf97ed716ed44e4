// The unit square onto the unit disk, area for area: Shirley and Chiu, "A Low Distortion Map Between Disk and Square",
// JGT 2(3), 1997.
#pragma once

#include "base/elementary.h"

namespace tilecast {

// u: in [0, 1)^2.
inline Vec2 square_to_disk(const Vec2& u) {
  double a = 2.0 * u.x - 1.0, b = 2.0 * u.y - 1.0;
  if (a == 0.0 && b == 0.0) return {0.0, 0.0};
  double r, turn;  // turn: angle over 2 pi
  if (std::fabs(a) > std::fabs(b)) {
    r = a;
    turn = 0.125 * (b / a);
  } else {
    r = b;
    turn = 0.25 - 0.125 * (a / b);
  }
  if (turn < 0.0) turn += 1.0;
  double sine, cosine;
  sincos_2pi(turn, sine, cosine);
  return {r * cosine, r * sine};
}

}  // namespace tilecast
