// fresnel_dielectric() of optics/fresnel.h for eight rays at once: the same operations, and so the same bits.
#pragma once

#include "base/twofold_lanes.h"

namespace tilecast {

struct FresnelLanes {
  Double8 reflectance, cos_transmitted;
  uint32_t total;  // one bit a lane
};

inline FresnelLanes fresnel_dielectric(const Double8& c, const Double8& eta) {
  const Double8 one = 1.0;
  const TwofoldLanes eta2 = two_product(eta, eta), c2 = two_product(c, c);
  const Mask8d by_c = c2.hi >= 0.5;
  const TwofoldLanes near = two_sum(choose(by_c, eta2.hi, eta2.hi - one), choose(by_c, c2.hi - one, c2.hi));
  const TwofoldLanes rest = two_sum(eta2.lo, c2.lo), sum = two_sum(near.hi, rest.hi);
  const Double8 g2 = sum.hi + (sum.lo + (near.lo + rest.lo));
  const Mask8d total = g2 <= 0.0;
  const Double8 g = sqrt(choose(total, one, g2)), sin2 = (one - c) * (one + c);
  const Double8 a = ((eta2.hi - one) + eta2.lo) / ((g + c) * (g + c)), b = (c * g - sin2) / (c * g + sin2);
  Double8 reflectance = Double8(0.5) * a * a * (one + b * b);
  const Mask8d much = reflectance > 0.3;
  if (bits(much) != 0) {
    const Double8 s = g + c, p = eta * eta * c + g;
    reflectance = choose(much, one - Double8(2.0) * c * g * (one / (s * s) + eta * eta / (p * p)), reflectance);
  }
  return {choose(total, one, reflectance), choose(total, 0.0, g / eta), bits(total)};
}

}  // namespace tilecast
