// The first crossings of eight rays with a CSG of a few solids, as scene/csg_search.h finds each ray's: the same bounds and
// the same rules, with rays instead of operands side by side.
#pragma once

#include "scene/ray_lanes.h"
#include "scene/scene.h"

namespace tilecast {

struct CrossingLanes {
  uint32_t found = 0, unsure = 0;  // one bit a lane. Unsure: to be asked for alone
  // Of those that are found, where it is not only asked whether.
  Double8 t = 0.0;
  int32_t operand[kLanes], face[kLanes];
  uint32_t entering = 0;
};

inline bool has_lanes(const Csg& csg) { return !csg.filter.singles.empty(); }

// In t_min < t <= t_max, of the lanes whose bits are set. kAny: whether there is one.
template <bool kAny>
void first_crossings(const Scene& scene, const Csg& csg, const RayLanes& rays, uint32_t lanes, const Double8& t_min,
                     const Double8& t_max, CrossingLanes& out);

}  // namespace tilecast
