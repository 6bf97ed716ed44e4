// sRGB as linear light (IEC 61966-2-1).
#pragma once

#include <cmath>

namespace tilecast {

// value: 0 to 1. Without libm's pow, whose bits depend on the machine.
inline float srgb_to_linear(float value) {
  if (value <= 0.04045f) return static_cast<float>(value / 12.92);
  const double x = (value + 0.055) / 1.055, square = x * x;
  // x^2.4 = x^2 (x^2)^(1/5); the root by Newton's method, whose error squares with each step, from above.
  double root = 0.6 + 0.6 * square;
  for (int i = 0; i < 8; ++i) root = (4.0 * root + square / (root * root * root * root)) / 5.0;
  return static_cast<float>(square * root);
}

}  // namespace tilecast
