#include "geometry/quadric.h"

#include "base/frame.h"
#include "geometry/block.h"
#include "geometry/quadratic.h"

namespace tilecast {
namespace {

struct Vector {
  Twofold x, y, z;
};
Twofold dot(const Vector& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// Half the second derivatives, times v.
Vector curvature(const Quadric& q, const Vec3& v) {
  const auto& c = q.coefficients;
  return {twofold_dot(Vec3(c[0], 0.5 * c[3], 0.5 * c[4]), v), twofold_dot(Vec3(0.5 * c[3], c[1], 0.5 * c[5]), v),
          twofold_dot(Vec3(0.5 * c[4], 0.5 * c[5], c[2]), v)};
}
Vec3 linear(const Quadric& q) { return {q.coefficients[6], q.coefficients[7], q.coefficients[8]}; }

Twofold value(const Quadric& q, const Vec3& p) {
  return dot(curvature(q, p), p) + twofold_dot(linear(q), p) + q.coefficients[9];
}
Vec3 gradient(const Quadric& q, const Vec3& p) {
  Vector c = curvature(q, p);
  return 2.0 * Vec3(c.x.hi, c.y.hi, c.z.hi) + linear(q);
}

}  // namespace

Quadric Quadric::of(std::array<double, 10> coefficients, const Vec3& lo, const Vec3& hi) {
  check(Block{lo, hi});
  double largest = 0.0;
  for (int i = 0; i < 10; ++i) {
    double c = coefficients[i];
    if (!(std::fabs(c) <= kLongest))
      throw Error("coefficients[" + std::to_string(i) + "]: must lie between -1e100 and 1e100, got " + text(c));
    if (i < 9) largest = std::max(largest, std::fabs(c));
  }
  if (largest == 0.0) throw Error("coefficients: must not all be 0 but for the last: that is no surface");
  if (largest < kShortest) throw Error("coefficients: the largest must be at least 1e-100, got " + text(largest));
  Quadric out{coefficients, 1.0 / power_below_reciprocal(2.0 * std::max(max_abs(lo), max_abs(hi))), lo, hi};
  for (int i = 0; i < 9; ++i) out.coefficients[i] *= out.unit;
  for (int i = 0; i < 6; ++i) out.coefficients[i] *= out.unit;
  largest = 0.0;
  for (double c : out.coefficients) largest = std::max(largest, std::fabs(c));
  for (double& c : out.coefficients) c *= power_below_reciprocal(largest);
  return out;
}

Intervals inside(const Quadric& q, const Ray& line) {
  Intervals out;
  const Interval box = inside_block(q.lo, q.hi, line, 1);
  if (box.empty) return out;
  Vec3 o = line.origin / q.unit;
  double stretch = power_below_reciprocal(max_abs(line.direction)), unit = stretch * q.unit;
  Vec3 d = line.direction * stretch;
  Vector along = curvature(q, d);
  Twofold a = dot(along, d), b = dot(along, o) + twofold_dot(0.5 * linear(q), d), c = value(q, o);
  QuadraticRoots roots;
  if (!solve(a, b, c, roots)) {
    if ((a.hi < 0.0 && roots.discriminant <= 0.0) || (a.hi == 0.0 && c.value() < 0.0)) out.add(box);
    return out;
  }
  // A displaced line changes the function by its gradient, and by its curvature to the second order.
  Vec3 moved = 4 * kUnitRoundoff * (glm::abs(o) + 1.0);
  double second = moved.x + moved.y + moved.z;
  auto crossing = [&](double t, bool entering) {
    double perturbation = glm::dot(glm::abs(gradient(q, o + t * d)), moved) + 8.0 * second * second;
    return SolidCrossing{t * unit, unit * roots.error(a.hi, perturbation), 0, entering};
  };
  auto add = [&](Interval part) {
    part.intersect(box);
    out.add(part);
  };
  Interval part;
  if (!(a.hi < 0.0)) {
    part.enter = crossing(roots.low, true);
    part.exit = crossing(roots.high, false);
    add(part);
  } else {
    part.exit = crossing(roots.low, false);
    add(part);
    part = Interval{};
    part.enter = crossing(roots.high, true);
    add(part);
  }
  return out;
}

Vec3 outward(const Quadric& q, int face, const Vec3& p) {
  return face == 0 ? gradient(q, p / q.unit) : block_outward(face - 1);
}

Vec3 project(const Quadric& q, int face, const Vec3& point) {
  if (face != 0) return block_project(q.lo, q.hi, face - 1, point);
  Vec3 p = point / q.unit;
  for (int step = 0; step < 2; ++step) {  // Newton's, towards the nearest
    Vec3 slope = gradient(q, p);
    Vec3 change = slope * (value(q, p).value() / glm::dot(slope, slope));
    if (max_abs(change) < 0x1p-10) p -= change;  // not at a singular point
  }
  return p * q.unit;
}

}  // namespace tilecast
