// Where a line lies within a radius of the origin, in space or in a plane: spheres, the sides of cylinders, and what
// is made of both.
#pragma once

#include "base/frame.h"
#include "geometry/interval.h"
#include "geometry/quadratic.h"

namespace tilecast {

inline double max_abs(const Vec2& v) { return std::max(std::fabs(v.x), std::fabs(v.y)); }

// A line's origin as seen from another place than its own zero.
template <class V>
struct Shift {
  V rest;           // what its coordinates lost to rounding
  double distance;  // of that place, at most
};

// Whether the line's nearest point is outside for sure: the radius has room for the rounding here.
template <class V>
inline bool passes_by(const V& o, const V& d, double radius) {
  V nearest = o - glm::dot(o, d) / glm::dot(d, d) * d;
  return glm::dot(nearest, nearest) > radius * radius;
}

// A line and a radius, lengths in units of about the radius and the direction brought near 1 by powers of two, so that
// nothing overflows and a scene scaled by a power of two gives the same digits.
template <class V>
struct NearOne {
  double scale;  // from the line's lengths to these
  double unit;   // from t here to the line's
  V o, d;
  double radius;
  bool still;    // the direction is zero

  NearOne(const V& origin, const V& direction, double r) {
    const double longest = max_abs(direction), stretch = power_below_reciprocal(longest);
    scale = power_below_reciprocal(r);
    unit = stretch * power_below(r);
    o = origin * scale;
    d = direction * stretch;
    radius = r * scale;
    still = longest == 0.0;
  }
};

template <class V>
inline Interval inside_ball(const V& origin, const V& direction, double radius, int face,
                            const Shift<V>* shift = nullptr) {
  const NearOne<V> near(origin, direction, radius);
  const V &o = near.o, &d = near.d;
  const double r = near.radius, farthest = max_abs(o);
  if (passes_by(o, d, r + 0x1p-48 * farthest)) return Interval::nothing();
  Twofold a = twofold_dot(d, d), b = twofold_dot(o, d), c = twofold_square(o, r);
  if (shift) {
    V low = shift->rest * near.scale;
    b = b + Twofold(glm::dot(low, d));
    c = c + two_product(2.0, glm::dot(o, low));
  }
  Interval interval;
  if (near.still) {
    interval.empty = !(c.value() < 0.0);
    return interval;
  }
  QuadraticRoots roots;
  if (!solve(a, b, c, roots)) return Interval::nothing();
  // A line displaced by this much changes the squared distance by 2 r displacement + displacement^2.
  double displacement = 4 * kUnitRoundoff * (farthest + r + (shift ? shift->distance * near.scale : 0.0));
  double error = near.unit * roots.error(a.hi, displacement * (2.0 * r + displacement));
  interval.enter = {roots.low * near.unit, error, face, true};
  interval.exit = {roots.high * near.unit, error, face, false};
  if (!(interval.enter.t < interval.exit.t)) interval.empty = true;
  return interval;
}

// v brought to the given length; where it has no direction, `otherwise`.
template <class V>
inline V of_length(const V& v, double length, const V& otherwise) {
  double now = std::sqrt(glm::dot(v, v));
  return now > 0.0 ? v * (length / now) : otherwise;
}

// An arm that gives a direction, however short it is; where it gives none, `otherwise`.
inline Vec3 direction_of(const Vec3& arm, const Vec3& otherwise) {
  if (max_abs(arm) >= 0x1p-400) return arm;
  const Vec3 longer = arm * 0x1p600;
  return max_abs(longer) >= 0x1p-400 ? longer : otherwise;
}

}  // namespace tilecast
