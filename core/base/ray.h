// A ray {origin + t * direction : t_min < t < t_max}. The direction may have any length: going into object space
// changes it and keeps t.
#pragma once

#include "base/vec.h"

namespace tilecast {

struct Ray {
  Vec3 origin;
  Vec3 direction;
  double t_min = 0.0;
  double t_max = kInfinity;

  Vec3 at(double t) const { return origin + t * direction; }
};

}  // namespace tilecast
