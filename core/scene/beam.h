// A bound around several lines: boxes that it misses are missed by all of them. Interval arithmetic on the slab test:
// Boulos, Wald and Shirley, "Geometric and Arithmetic Culling Methods for Entire Ray Packets", UUCS-06-010, 2006. Rounding
// is monotone, so that the bounds hold for the lines' own tests in float as well.
#pragma once

#include "scene/ray_lanes.h"

namespace tilecast {

class RayBeam {
 public:
  RayBeam(const FloatLines& lines, uint32_t lanes, Float8 s_min) {
    const Mask8 meant = lanes_of(lanes);
    const Float8 far = all(std::numeric_limits<float>::infinity());
    auto low = [&](Float8 x) { return least(meant ? x : far); };
    auto high = [&](Float8 x) { return greatest(meant ? x : -far); };
    s_min_ = low(s_min);
    for (int i = 0; i < 3; ++i) {
      const Float8 per = lines.directions->reciprocal[i];
      const float o_low = low(lines.origin[i]), o_high = high(lines.origin[i]);
      low_[i] = low(per), high_[i] = high(per);
      up_[i] = low_[i] > 0.0f;
      mixed_[i] = low_[i] < 0.0f && high_[i] > 0.0f;
      near_[i] = up_[i] ? o_high : o_low, far_[i] = up_[i] ? o_low : o_high;
    }
  }

  Mask8 meets(const BoxLanes& boxes, float s_max, Float8& from) const {
    Float8 to = all(s_max);
    from = all(s_min_);
    for (int i = 0; i < 3; ++i) {
      if (mixed_[i]) continue;
      const Float8 a = (up_[i] ? boxes.lo : boxes.hi)[i] - near_[i], b = (up_[i] ? boxes.hi : boxes.lo)[i] - far_[i];
      from = max(from, min(a * low_[i], a * high_[i]));
      to = min(to, max(b * low_[i], b * high_[i]));
    }
    return from <= to;
  }

 private:
  float s_min_, low_[3], high_[3], near_[3], far_[3];
  bool up_[3], mixed_[3];
};

}  // namespace tilecast
