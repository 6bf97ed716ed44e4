#include "geometry/cone.h"

#include "geometry/ball.h"

namespace tilecast {
namespace {

// Of the side alone, both nappes' planes apart; in t of the line.
Interval inside_side(const Cone& c, const Ray& line) {
  // Across and along the axis lengths come near 1 by powers of two of their own: t stays.
  double across = power_below_reciprocal(std::max(c.radius, c.top_radius)), along = power_below_reciprocal(c.height);
  Vec3 o = line.origin * Vec3(across, along, across), d = line.direction * Vec3(across, along, across);
  double stretch = power_below_reciprocal(max_abs(d));
  d *= stretch;
  double height = c.height * along, bottom = c.radius * across, top = c.top_radius * across;

  // w(t) = start + slope t
  Twofold taper = two_sum(top, -bottom), squared_height = two_product(height, height);
  Twofold start = two_product(0.5 * height, bottom) + two_product(0.5 * height, top) + taper * o.y;
  Twofold slope = taper * d.y;
  Vec2 flat_o(o.x, o.z), flat_d(d.x, d.z);
  Twofold a = squared_height * twofold_dot(flat_d, flat_d) - slope * slope;
  Twofold b = squared_height * twofold_dot(flat_o, flat_d) - start * slope;
  Twofold q = squared_height * twofold_dot(flat_o, flat_o) - start * start;

  Interval interval;
  QuadraticRoots roots;
  if (!solve(a, b, q, roots)) {
    if (a.hi < 0.0 && roots.discriminant <= 0.0) {  // steeper than the side, and so through the apex to within rounding
      roots.low = roots.high = -b.value() / a.value();
      roots.discriminant = roots.root = 0.0;
    } else {
      interval.empty = !(a.hi == 0.0 && q.value() < 0.0);  // a cylinder, from within along its axis
      return interval;
    }
  }
  // To first order a displaced line changes the function by the gradient, which vanishes with w.
  double moved_across = 4 * kUnitRoundoff * (std::fabs(o.x) + std::fabs(o.z) + 2.0);
  double moved_along = 4 * kUnitRoundoff * (std::fabs(o.y) + height);
  double moved = height * moved_across + std::fabs(taper.hi) * moved_along;
  auto crossing = [&](double t, bool entering) {
    double w = std::fabs(start.hi + slope.hi * t) + 2.0 * moved;
    return SolidCrossing{t * stretch, stretch * roots.error(a.hi, 3.0 * moved * w), 0, entering};
  };
  if (!(a.hi < 0.0)) {
    interval.enter = crossing(roots.low, true);
    interval.exit = crossing(roots.high, false);
    if (!(interval.enter.t < interval.exit.t)) interval.empty = true;
  } else if (slope.hi > 0.0) {
    interval.enter = crossing(roots.high, true);
  } else {
    interval.exit = crossing(roots.low, false);
  }
  return interval;
}

}  // namespace

void check(const Cone& c) {
  for (auto [r, name] : {std::pair{c.radius, "radius"}, {c.top_radius, "top_radius"}})
    if (r != 0.0) {
      if (!(r > 0.0)) throw Error(std::string(name) + ": must not be negative, got " + text(r));
      check_length(r, name);
    }
  if (c.radius == 0.0 && c.top_radius == 0.0) throw Error("radius: must be positive where top_radius is 0, got 0");
  check_positive(c.height, "height");
}

Box bounds(const Cone& c) {
  double r = std::max(c.radius, c.top_radius);
  return {Vec3(-r, -0.5 * c.height, -r), Vec3(r, 0.5 * c.height, r)};
}

Interval inside(const Cone& c, const Ray& line) {
  Interval interval = inside_slab(line.origin.y, line.direction.y, -0.5 * c.height, 0.5 * c.height, 1, 2);
  if (!interval.empty) interval.intersect(inside_side(c, line));
  return interval;
}

Vec3 outward(const Cone& c, int face, const Vec3& p) {
  if (face != 0) return Vec3(0.0, face == 1 ? -1.0 : 1.0, 0.0);
  // (x, z) / rho and (radius - top_radius) / height, cleared of the larger denominator.
  double rho = std::sqrt(p.x * p.x + p.z * p.z), taper = c.radius - c.top_radius;
  if (rho == 0.0) return Vec3(0.0, taper, 0.0);
  Vec2 radial = Vec2(p.x, p.z) / rho;
  return c.height > std::fabs(taper) ? Vec3(radial.x, taper / c.height, radial.y)
                                     : Vec3(radial.x * (c.height / std::fabs(taper)), std::copysign(1.0, taper),
                                            radial.y * (c.height / std::fabs(taper)));
}

Vec3 project(const Cone& c, int face, const Vec3& p) {
  if (face != 0) return Vec3(p.x, face == 1 ? -0.5 * c.height : 0.5 * c.height, p.z);
  // Along the normal of the side, in the plane of the axis and the point.
  double taper = c.top_radius - c.radius, rho = std::sqrt(p.x * p.x + p.z * p.z);
  double beyond = rho - (c.radius + (p.y / c.height + 0.5) * taper);
  double off = beyond * (c.height / (c.height * c.height + taper * taper));
  double r = std::max(rho - off * c.height, 0.0);
  Vec2 side = of_length(Vec2(p.x, p.z), r, Vec2(r, 0.0));
  return Vec3(side.x, p.y + off * taper, side.y);
}

}  // namespace tilecast
