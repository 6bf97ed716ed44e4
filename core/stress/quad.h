// Solids in quadruple precision, by their implicit functions: what the crossings in double are held against.
#pragma once

#include <array>
#include <vector>

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

// A polynomial, lowest power first.
using QuadPolynomial = std::vector<Quad>;

inline Quad evaluate(const QuadPolynomial& p, Quad t) {
  Quad value = 0;
  for (size_t i = p.size(); i-- > 0;) value = value * t + p[i];
  return value;
}

// The torus's implicit function along the line.
inline QuadPolynomial quartic_along(const Torus& t, const Ray& line) {
  const Vec3 &o = line.origin, &d = line.direction;
  Quad l0 = square(o.x) + square(o.z), l1 = Quad(o.x) * d.x + Quad(o.z) * d.z, l2 = square(d.x) + square(d.z);
  Quad a = l2 + square(d.y), b = l1 + Quad(o.y) * d.y, k = l0 + square(o.y) + square(t.radius) - square(t.minor_radius);
  Quad four = 4 * square(t.radius);
  return {k * k - four * l0, 4 * b * k - 2 * four * l1, 4 * b * b + 2 * a * k - four * l2, 4 * a * b, a * a};
}

// How many different real roots a polynomial has: the changes of sign in Sturm's sequence, at both infinities.
inline int sturm_count(QuadPolynomial p) {
  std::vector<QuadPolynomial> sequence{p, {}};
  for (size_t i = 1; i < p.size(); ++i) sequence[1].push_back(p[i] * static_cast<double>(i));
  while (sequence.back().size() > 1) {
    QuadPolynomial remainder = sequence[sequence.size() - 2];
    const QuadPolynomial& divisor = sequence.back();
    while (remainder.size() >= divisor.size()) {
      Quad factor = remainder.back() / divisor.back();
      size_t shift = remainder.size() - divisor.size();
      for (size_t i = 0; i + 1 < divisor.size(); ++i) remainder[i + shift] -= factor * divisor[i];
      remainder.pop_back();
    }
    while (!remainder.empty() && remainder.back() == 0) remainder.pop_back();
    if (remainder.empty()) break;
    Quad largest = 0;
    for (Quad& c : remainder) largest = larger(largest, magnitude(c = -c));
    for (Quad& c : remainder) c /= largest;
    sequence.push_back(remainder);
  }
  int below = 0, above = 0;
  for (size_t i = 1; i < sequence.size(); ++i) {
    const QuadPolynomial &a = sequence[i - 1], &b = sequence[i];
    bool same = (a.back() > 0) == (b.back() > 0), odd = (a.size() + b.size()) & 1;
    above += !same;
    below += same == odd;
  }
  return below - above;
}

}  // namespace tilecast::stress
