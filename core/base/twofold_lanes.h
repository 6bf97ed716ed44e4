// base/twofold.h for eight numbers at once: the same operations, and so the same bits.
#pragma once

#include "base/lanes64.h"

namespace tilecast {

struct TwofoldLanes {
  Double8 hi, lo;

  Double8 value() const { return hi + lo; }
};

inline TwofoldLanes two_sum(const Double8& a, const Double8& b) {
  const Double8 sum = a + b, part = sum - a;
  return {sum, (a - (sum - part)) + (b - part)};
}
inline TwofoldLanes two_product(const Double8& a, const Double8& b) {
  const Double8 product = a * b;
  return {product, fma(a, b, -product)};
}
template <int n>
[[gnu::always_inline]] inline TwofoldLanes twofold_dot(const Double8 (&a)[n], const Double8 (&b)[n]) {
  TwofoldLanes sum = two_product(a[0], b[0]);
  for (int i = 1; i < n; ++i) {
    const TwofoldLanes product = two_product(a[i], b[i]), next = two_sum(sum.hi, product.hi);
    sum = {next.hi, sum.lo + (next.lo + product.lo)};
  }
  return sum;
}
template <int n>
[[gnu::always_inline]] inline TwofoldLanes twofold_square(const Double8 (&v)[n], double x) {
  const TwofoldLanes sum = twofold_dot(v, v), product = two_product(Double8(x), Double8(x)),
                     rest = two_sum(sum.hi, -product.hi);
  return {rest.hi, sum.lo + (rest.lo - product.lo)};
}

}  // namespace tilecast
