// A ball seen from outside: directions uniform in the cone that it fills.
//
// Pharr, Jakob and Humphreys, "Physically Based Rendering", 4th edition, 6.2.4, in forms that cancel neither for balls
// that are tiny nor for those that are near: 1 - cos is sin^2 / (1 + cos), and cos^2 is (d - r) (d + r) / d^2.
#pragma once

#include <algorithm>

#include "base/elementary.h"
#include "shading/basis.h"

namespace tilecast {

struct BallCone {
  double distance = 0.0;         // of the centre, metres
  double sine = 0.0;             // of the cone's half angle
  double one_minus_cosine = 0.0;

  // Per solid angle; 0: from inside the ball, or too small or too large for numbers.
  double pdf() const { return one_minus_cosine > 0.0 ? 1.0 / (2.0 * kPi * one_minus_cosine) : 0.0; }
};

inline BallCone cone_of(const Vec3& to_centre, double radius) {
  const double distance = glm::length(to_centre);
  if (!(distance > radius)) return {};
  const double sine = radius / distance;
  const double cosine = std::sqrt((distance - radius) * (distance + radius)) / distance;
  return {distance, sine, sine * sine / (1.0 + cosine)};
}

// The normal of the point of the ball that is seen in a direction of the cone.
inline Vec3 sample_normal(const BallCone& cone, const Vec3& to_centre, const Vec2& u) {
  // v: 1 - cos of the angle off the cone's axis. The angle at the centre is that off the axis taken from the one at
  // which the ball is met.
  const double v = u.x * cone.one_minus_cosine, sin2 = v * (2.0 - v);
  const double met = std::sqrt(std::max(0.0, 1.0 - sin2 / (cone.sine * cone.sine)));
  const double cosine = std::min(1.0, sin2 / cone.sine + (1.0 - v) * met);
  const double sine = std::sqrt((1.0 - cosine) * (1.0 + cosine));
  double across, along;
  sincos_2pi(u.y, across, along);
  return Basis(to_centre / cone.distance).to_world(Vec3(sine * along, sine * across, -cosine));
}

}  // namespace tilecast
