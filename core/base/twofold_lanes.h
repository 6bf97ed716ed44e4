// base/twofold.h for several numbers at once: the same operations, and so the same bits. D: Double4 or Double8.
#pragma once

#include "base/lanes64.h"

namespace tilecast {

template <class D>
struct TwofoldLanes {
  D hi, lo;

  D value() const { return hi + lo; }
};

template <class D>
inline TwofoldLanes<D> two_sum(const D& a, const D& b) {
  const D sum = a + b, part = sum - a;
  return {sum, (a - (sum - part)) + (b - part)};
}
template <class D>
inline TwofoldLanes<D> two_product(const D& a, const D& b) {
  const D product = a * b;
  return {product, fma(a, b, -product)};
}
template <class D, int n>
[[gnu::always_inline]] inline TwofoldLanes<D> twofold_dot(const D (&a)[n], const D (&b)[n]) {
  TwofoldLanes<D> sum = two_product(a[0], b[0]);
  for (int i = 1; i < n; ++i) {
    const TwofoldLanes<D> product = two_product(a[i], b[i]), next = two_sum(sum.hi, product.hi);
    sum = {next.hi, sum.lo + (next.lo + product.lo)};
  }
  return sum;
}
template <class D, int n>
[[gnu::always_inline]] inline TwofoldLanes<D> twofold_square(const D (&v)[n], double x) {
  const TwofoldLanes<D> sum = twofold_dot(v, v), product = two_product(D{} + x, D{} + x),
                        rest = two_sum(sum.hi, -product.hi);
  return {rest.hi, sum.lo + (rest.lo - product.lo)};
}

}  // namespace tilecast
