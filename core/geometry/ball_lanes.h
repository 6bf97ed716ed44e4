// geometry/ball.h and geometry/quadratic.h for several lines at once: the same operations, and so the same bits. D: Double4
// or Double8.
#pragma once

#include "base/twofold_lanes.h"
#include "geometry/ball.h"

namespace tilecast {

template <class D, int n>
struct NearOneLanes {
  D o[n], d[n], unit;
  double radius;
  decltype(D{} == D{}) still;

  [[gnu::always_inline]] NearOneLanes(const D (&origin)[n], const D (&direction)[n], double r) {
    D longest = abs(direction[0]);
    for (int i = 1; i < n; ++i) longest = max(longest, abs(direction[i]));
    const D stretch = power_below_reciprocal(longest);
    const double scale = power_below_reciprocal(r);
    unit = stretch * power_below(r);
    for (int i = 0; i < n; ++i) o[i] = origin[i] * scale, d[i] = direction[i] * stretch;
    radius = r * scale;
    still = longest == 0.0;
  }
};

// Of the ball's equation: discriminate().
template <class D>
struct BallRoots {
  TwofoldLanes<D> a, c;
  D q;
  decltype(D{} > D{}) meets;

  template <int n>
  [[gnu::always_inline]] explicit BallRoots(const NearOneLanes<D, n>& near) : a(twofold_dot(near.d, near.d)) {
    const TwofoldLanes<D> b = twofold_dot(near.o, near.d);
    c = twofold_square(near.o, near.radius);
    const D product = a.hi * c.hi, remainder = fma(a.hi, c.hi, -product);
    const D low = 2.0 * b.hi * b.lo - fma(a.hi, c.lo, a.lo * c.hi);
    const D discriminant = fma(b.hi, b.hi, -product) + (low - remainder);
    meets = discriminant > 0.0;
    const D root = sqrt(choose(meets, discriminant, D{} + 1.0));
    q = -(b.hi + copysign(root, b.hi) + b.lo);
  }
};

}  // namespace tilecast
