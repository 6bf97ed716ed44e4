// What four rays meet of a plain scene: the answers of scene/trace.h, bit for bit. Every object is asked, so that the four
// need not go the same way. kChalk: PlainScene::chalk, where no balls are looked for.
#pragma once

#include "base/double_lanes.h"
#include "scene/plain_scene.h"

namespace tilecast {

struct PlainHits {
  Double4 t = all(kInfinity);
  Mask4 face = all(true);  // number in the scene; -1: nothing
  Mask4 entering{};
};

// The first hits in t > 0.
template <bool kChalk>
PlainHits closest(const PlainScene& plain, const Vec3x4& origin, const Vec3x4& direction);

// Whether anything is hit in 0 < t <= 1; right for the rays that are asked for, whatever it says of others.
template <bool kChalk>
Mask4 occluded(const PlainScene& plain, const Vec3x4& origin, const Vec3x4& direction, Mask4 asked);

}  // namespace tilecast
