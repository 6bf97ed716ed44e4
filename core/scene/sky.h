// The clear sky by day: Preetham, Shirley and Smits, "A Practical Analytic Model for Daylight", SIGGRAPH 1999.
#pragma once

#include "scene/environment.h"

namespace tilecast {

struct Sky {
  Vec3 sun{0.0, 1.0, 0.0};  // the direction towards it, of any length; not below the horizon
  double turbidity = 3.0;   // haze: 2 is very clear, 10 is misty
  Rgb ground{0.2};          // reflectance of what lies below the horizon
  double scale = 0.1;       // radiance for each 1,000 cd/m^2
};

// Without the sun's disk. Throws Error where a parameter is out of range.
Environment make_environment(const Sky& sky);

}  // namespace tilecast
