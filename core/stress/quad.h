// Solids in quadruple precision, by their implicit functions: what the crossings in double are held against.
#pragma once

#include <algorithm>
#include <cmath>

#include "geometry/solid.h"

namespace tilecast::stress {

using Quad = __float128;  // 113 bits

inline Quad magnitude(Quad x) { return x < 0 ? -x : x; }
inline Quad square(Quad x) { return x * x; }
inline Quad larger(Quad a, Quad b) { return a > b ? a : b; }

// Newton's method from the root in double.
inline Quad root_of(Quad x) {
  if (x <= 0) return 0;
  Quad s = std::sqrt(static_cast<double>(x));
  for (int i = 0; i < 3; ++i) s = (s + x / s) / 2;
  return s;
}

struct QuadPoint {
  Quad x, y, z;
  Quad operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
};
inline QuadPoint at(const Ray& line, Quad t) {
  const Vec3 &o = line.origin, &d = line.direction;
  return {o.x + t * d.x, o.y + t * d.y, o.z + t * d.z};
}

// Negative inside.
inline Quad implicit(const Vec3& lo, const Vec3& hi, const QuadPoint& p) {
  Quad most = lo.x - p.x;
  for (int i = 0; i < 3; ++i) most = larger(most, larger(lo[i] - p[i], p[i] - hi[i]));
  return most;
}
inline Quad implicit(const Sphere& s, const QuadPoint& p) {
  return square(p.x) + square(p.y) + square(p.z) - square(s.radius);
}
inline Quad implicit(const Block& b, const QuadPoint& p) { return implicit(b.lo, b.hi, p); }
inline Quad implicit(const Cylinder& c, const QuadPoint& p) {
  return larger(square(p.x) + square(p.z) - square(c.radius), magnitude(p.y) - Quad(c.height) / 2);
}
inline Quad implicit(const Cone& c, const QuadPoint& p) {
  Quad w = c.radius * (Quad(c.height) / 2 - p.y) + c.top_radius * (Quad(c.height) / 2 + p.y);
  return larger(square(c.height) * (square(p.x) + square(p.z)) - square(w), magnitude(p.y) - Quad(c.height) / 2);
}
inline Quad implicit(const Capsule& c, const QuadPoint& p) {
  Quad beyond = larger(magnitude(p.y) - Quad(c.height) / 2, 0);
  return square(p.x) + square(beyond) + square(p.z) - square(c.radius);
}
inline Quad implicit(const Torus& t, const QuadPoint& p) {
  Quad flat = square(p.x) + square(p.z);
  Quad sum = flat + square(p.y) + square(t.radius) - square(t.minor_radius);
  return square(sum) - 4 * square(t.radius) * flat;
}
inline Quad implicit(const RoundedBlock& b, const QuadPoint& p) {
  Quad sum = -square(b.radius);
  for (int i = 0; i < 3; ++i)
    sum += square(larger(larger(Quad(b.lo[i]) + b.radius - p[i], p[i] - (Quad(b.hi[i]) - b.radius)), 0));
  return sum;
}
inline Quad implicit(const Quadric& q, const QuadPoint& p) {
  const auto& c = q.coefficients;
  Quad x = p.x / q.unit, y = p.y / q.unit, z = p.z / q.unit;
  Quad f = c[0] * x * x + c[1] * y * y + c[2] * z * z + c[3] * x * y + c[4] * x * z + c[5] * y * z + c[6] * x +
           c[7] * y + c[8] * z + c[9];
  return larger(f, implicit(q.lo, q.hi, p));
}
inline Quad implicit(const Halfspace& h, const QuadPoint& p) {
  return larger(h.normal.x * p.x + h.normal.y * p.y + h.normal.z * p.z - h.offset, implicit(h.lo, h.hi, p));
}
inline Quad implicit(const Solid& solid, const QuadPoint& p) {
  return std::visit([&](const auto& s) { return implicit(s, p); }, solid);
}

// A polynomial of degree 4 at most, lowest power first.
struct QuadPolynomial {
  Quad coefficient[5] = {};
  int degree = 4;

  Quad leading() const { return coefficient[degree]; }
};

inline Quad evaluate(const QuadPolynomial& p, Quad t) {
  Quad value = p.leading();
  for (int i = p.degree; i-- > 0;) value = value * t + p.coefficient[i];
  return value;
}

// The torus's implicit function along the line.
inline QuadPolynomial quartic_along(const Torus& t, const Ray& line) {
  const Vec3 &o = line.origin, &d = line.direction;
  Quad l0 = square(o.x) + square(o.z), l1 = Quad(o.x) * d.x + Quad(o.z) * d.z, l2 = square(d.x) + square(d.z);
  Quad a = l2 + square(d.y), b = l1 + Quad(o.y) * d.y, k = l0 + square(o.y) + square(t.radius) - square(t.minor_radius);
  Quad four = 4 * square(t.radius);
  return {{k * k - four * l0, 4 * b * k - 2 * four * l1, 4 * b * b + 2 * a * k - four * l2, 4 * a * b, a * a}};
}

// How many different real roots a polynomial has: the changes of sign in Sturm's sequence, at both infinities.
inline int sturm_count(QuadPolynomial p) {
  QuadPolynomial next;  // first the derivative
  next.degree = p.degree - 1;
  for (int i = 1; i <= p.degree; ++i) next.coefficient[i - 1] = p.coefficient[i] * i;
  int below = 0, above = 0;
  while (true) {
    bool same = (p.leading() > 0) == (next.leading() > 0), odd = (p.degree + next.degree) & 1;
    above += !same;
    below += same == odd;
    if (next.degree == 0) break;
    while (p.degree >= next.degree) {  // the remainder, in place
      Quad factor = p.leading() / next.leading();
      for (int i = 0; i < next.degree; ++i) p.coefficient[p.degree - next.degree + i] -= factor * next.coefficient[i];
      --p.degree;
    }
    while (p.degree >= 0 && p.leading() == 0) --p.degree;
    if (p.degree < 0) break;
    double largest = 0.0;
    for (int i = 0; i <= p.degree; ++i) largest = std::max(largest, std::fabs(static_cast<double>(p.coefficient[i])));
    const Quad scale = -std::ldexp(1.0, -std::ilogb(largest));  // a power of two rounds nothing
    for (int i = 0; i <= p.degree; ++i) p.coefficient[i] *= scale;
    std::swap(p, next);
  }
  return below - above;
}

}  // namespace tilecast::stress
