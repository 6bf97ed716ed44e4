// Sums of many chunks. One after the other added to a growing total they stall: a constant, a million times, is off by
// 2e-11. What rounding loses is kept beside the total (base/twofold.h), which then is the rounded true sum of what was added.
#pragma once

#include <cstddef>

#include "base/twofold.h"

namespace tilecast {

// total[i] + lost[i] becomes what it was and more[i], for all i < count; |lost| stays below half a unit of the total's last place.
inline void add_sums(double* total, double* lost, const double* more, size_t count) {
  for (size_t i = 0; i < count; ++i) {
    const Twofold sum = Twofold(total[i], lost[i]) + Twofold(more[i]);
    total[i] = sum.hi, lost[i] = sum.lo;
  }
}

}  // namespace tilecast
