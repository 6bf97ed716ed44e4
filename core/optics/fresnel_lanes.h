// fresnel_dielectric() of optics/fresnel.h for several rays at once: the same operations, and so the same bits. D: Double4
// or Double8.
#pragma once

#include "base/twofold_lanes.h"

namespace tilecast {

template <class D>
struct FresnelLanes {
  D reflectance, cos_transmitted;
  decltype(D{} < D{}) total;
};

template <class D>
inline FresnelLanes<D> fresnel_dielectric(const D& c, const D& eta) {
  const D none{}, one = none + 1.0;
  const TwofoldLanes<D> eta2 = two_product(eta, eta), c2 = two_product(c, c);
  const auto by_c = c2.hi >= 0.5;
  const TwofoldLanes<D> near = two_sum(choose(by_c, eta2.hi, eta2.hi - one), choose(by_c, c2.hi - one, c2.hi));
  const TwofoldLanes<D> rest = two_sum(eta2.lo, c2.lo), sum = two_sum(near.hi, rest.hi);
  const D g2 = sum.hi + (sum.lo + (near.lo + rest.lo));
  const auto total = g2 <= 0.0;
  const D g = sqrt(choose(total, one, g2)), sin2 = (one - c) * (one + c);
  const D a = ((eta2.hi - one) + eta2.lo) / ((g + c) * (g + c)), b = (c * g - sin2) / (c * g + sin2);
  D reflectance = 0.5 * a * a * (one + b * b);
  const auto much = reflectance > 0.3;
  if (bits(much) != 0) {
    const D s = g + c, p = eta * eta * c + g;
    reflectance = choose(much, one - 2.0 * c * g * (one / (s * s) + eta * eta / (p * p)), reflectance);
  }
  return {choose(total, one, reflectance), choose(total, none, g / eta), total};
}

}  // namespace tilecast
