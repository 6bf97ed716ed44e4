// Numbers of twice double's precision, as unevaluated sums of two doubles: what is left of a difference of nearly equal
// products is then still right.
//
// Knuth's sum, Dekker's renormalisation and the fused product; sums and products as in Ogita, Rump and Oishi, "Accurate
// Sum and Dot Product", SISC 26(6), 2005. Each operation is off by a few u^2 of the magnitudes that go into it (not of
// the result), u = 2^-53, unless something underflows or overflows: callers keep their values near 1.
#pragma once

#include <cmath>

namespace tilecast {

struct Twofold {
  double hi = 0.0, lo = 0.0;

  Twofold() = default;
  Twofold(double high, double low = 0.0) : hi(high), lo(low) {}
  double value() const { return hi + lo; }
};

// Exact.
inline Twofold two_sum(double a, double b) {
  double sum = a + b, part = sum - a;
  return {sum, (a - (sum - part)) + (b - part)};
}
inline Twofold two_product(double a, double b) {
  double product = a * b;
  return {product, std::fma(a, b, -product)};
}
// Exact where |a| >= |b|.
inline Twofold ordered_sum(double a, double b) {
  double sum = a + b;
  return {sum, b - (sum - a)};
}

inline Twofold operator-(const Twofold& x) { return {-x.hi, -x.lo}; }
inline Twofold operator+(const Twofold& x, const Twofold& y) {
  Twofold s = two_sum(x.hi, y.hi);
  return ordered_sum(s.hi, s.lo + (x.lo + y.lo));
}
inline Twofold operator-(const Twofold& x, const Twofold& y) { return x + -y; }
inline Twofold operator*(const Twofold& x, const Twofold& y) {
  Twofold p = two_product(x.hi, y.hi);
  return ordered_sum(p.hi, p.lo + std::fma(x.hi, y.lo, x.lo * y.hi));
}

// a / b, the rounded quotient put right by what it leaves.
inline double quotient(const Twofold& a, const Twofold& b) {
  double q = a.value() / b.value();
  Twofold left = a - b * q;
  return q + left.value() / b.value();
}

// The scalar product of two vectors of doubles (GLM's, of any length). Not renormalised: the value is that of the sum.
template <class V>
inline Twofold twofold_dot(const V& a, const V& b) {
  Twofold sum = two_product(a[0], b[0]);
  for (int i = 1; i < V::length(); ++i) {
    Twofold product = two_product(a[i], b[i]), next = two_sum(sum.hi, product.hi);
    sum = {next.hi, sum.lo + (next.lo + product.lo)};
  }
  return sum;
}

// The same of a vector with itself, less x^2.
template <class V>
inline Twofold twofold_square(const V& v, double x) {
  Twofold sum = twofold_dot(v, v), product = two_product(x, x), rest = two_sum(sum.hi, -product.hi);
  return {rest.hi, sum.lo + (rest.lo - product.lo)};
}

}  // namespace tilecast
