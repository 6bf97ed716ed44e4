#include "geometry/torus.h"

#include "base/check.h"
#include "geometry/ball.h"
#include "geometry/polynomial.h"

namespace tilecast {
namespace {

// (|p|^2 + R^2 - r^2)^2 - 4 R^2 (x^2 + z^2) along p = o + s d: negative inside. `rest`: what o lost to rounding.
Quartic quartic(const Vec3& o, const Vec3& rest, const Vec3& d, double major, double minor) {
  Twofold x(o.x, rest.x), y(o.y, rest.y), z(o.z, rest.z);
  Twofold l0 = x * x + z * z, l1 = x * d.x + z * d.z, l2 = two_product(d.x, d.x) + two_product(d.z, d.z);
  Twofold a = l2 + two_product(d.y, d.y), b = l1 + y * d.y;
  Twofold k = l0 + y * y + two_sum(major, -minor) * two_sum(major, minor);
  Twofold four = two_product(2.0 * major, 2.0 * major);
  return {{k * k - four * l0, 4.0 * (b * k) - 2.0 * (four * l1), 4.0 * (b * b) + 2.0 * (a * k) - four * l2,
           4.0 * (a * b), a * a}};
}

// From the ring in the middle of the tube.
Vec3 arm_of(const Torus& t, const Vec3& p) {
  const Vec2 ring = of_length(Vec2(p.x, p.z), t.radius, Vec2(t.radius, 0.0));
  return p - Vec3(ring.x, 0.0, ring.y);
}

}  // namespace

void check(const Torus& t) {
  check_positive(t.radius, "radius");
  check_positive(t.minor_radius, "minor_radius");
  if (!(t.minor_radius <= t.radius))
    throw Error("minor_radius: must be at most radius = " + text(t.radius) + ", got " + text(t.minor_radius));
}

Box bounds(const Torus& t) {
  double across = t.radius + t.minor_radius;
  return {Vec3(-across, -t.minor_radius, -across), Vec3(across, t.minor_radius, across)};
}

Intervals inside(const Torus& t, const Ray& line) {
  Intervals out;
  double scale = power_below_reciprocal(t.radius), stretch = power_below_reciprocal(max_abs(line.direction));
  Vec3 from = line.origin * scale, d = line.direction * stretch;
  double major = t.radius * scale, minor = t.minor_radius * scale, reach = major + minor;

  // The part of the line that may be inside: within the ball around it, and between its two planes.
  double squared_length = glm::dot(d, d), start = -glm::dot(from, d) / squared_length;
  Vec3 o, rest;
  for (int i = 0; i < 3; ++i) {
    Twofold moved = two_product(start, d[i]) + from[i];
    o[i] = moved.hi;
    rest[i] = moved.lo;
  }
  double left = reach * reach * (1.0 + 0x1p-20) - glm::dot(o, o);
  if (!(left > 0.0 && squared_length >= 1.0)) return out;
  double high = std::sqrt(left / squared_length), low = -high;
  if (d.y != 0.0) {
    double margin = minor * (1.0 + 0x1p-20) + std::fabs(o.y) * 0x1p-50;
    double first = (-margin - o.y) / d.y, second = (margin - o.y) / d.y;
    low = std::max(low, std::min(first, second));
    high = std::min(high, std::max(first, second));
  } else if (!(std::fabs(o.y) < minor)) {
    return out;
  }
  if (!(low < high)) return out;

  Quartic p = quartic(o, rest, d, major, minor);
  Twofold root[4];
  int count = negative_between(p, low, high, root);
  double displacement = 4 * kUnitRoundoff * (max_abs(from) + reach);
  double unit = stretch / scale;
  SolidCrossing crossing[4];
  for (int i = 0; i < count; ++i) {
    Vec3 at = o + root[i].hi * d;
    // The gradient at the surface is 8 R r rho long.
    double rho = std::sqrt(at.x * at.x + at.z * at.z) + displacement;
    double error = root_error(p, root[i].hi, 16.0 * major * (minor + displacement) * rho * displacement, high - low);
    crossing[i] = {(start + root[i].hi + root[i].lo) * unit, error * unit, 0, i % 2 == 0};
  }
  for (int i = 0; i + 1 < count; i += 2) {
    Interval interval;
    interval.enter = crossing[i];
    interval.exit = crossing[i + 1];
    interval.empty = !(interval.enter.t < interval.exit.t);
    out.add(interval);
  }
  return out;
}

Vec3 outward(const Torus& t, int, const Vec3& p) { return direction_of(arm_of(t, p), Vec3(0.0, 1.0, 0.0)); }

Vec3 project(const Torus& t, int, const Vec3& p) {
  Vec3 arm = arm_of(t, p);
  return p + (of_length(arm, t.minor_radius, Vec3(0.0, t.minor_radius, 0.0)) - arm);
}

}  // namespace tilecast
