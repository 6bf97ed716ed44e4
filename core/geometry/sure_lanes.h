// What geometry/sure_crossing.h does, of eight lines at once: the same operations in the same order, and so the same bits.
#pragma once

#include "base/lanes64.h"
#include "geometry/solid.h"

namespace tilecast {

struct LineLanes {
  Double8 origin[3], direction[3];

  Ray line(int lane) const {
    return {{origin[0][lane], origin[1][lane], origin[2][lane]},
            {direction[0][lane], direction[1][lane], direction[2][lane]}};
  }
};

// Which crossings of solids there are lanes for: spheres, blocks and cylinders.
bool has_sure_lanes(const Solid& solid);

// Crossing number `number` of each line that has two; a bit for each that has. `face` receives its face's number.
uint32_t sure_crossings(const Solid& solid, const LineLanes& lines, int number, Double8& t, int32_t face[kLanes]);

// Whether t > 0 there, for sure: one bit a lane. A lane without either bit: it is not known.
struct SurelyAhead {
  uint32_t yes, no;
};
SurelyAhead sure_crossings_ahead(const Solid& solid, const LineLanes& lines, int number);

}  // namespace tilecast
