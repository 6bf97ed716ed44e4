// Axis-aligned boxes in double.
#pragma once

#include "base/vec.h"

namespace tilecast {

struct Box {
  Vec3 lo{kInfinity};
  Vec3 hi{-kInfinity};

  static Box everything() { return {Vec3(-kInfinity), Vec3(kInfinity)}; }

  bool empty() const { return !(lo.x <= hi.x && lo.y <= hi.y && lo.z <= hi.z); }
  bool unbounded() const { return lo.x == -kInfinity; }
  void extend(const Vec3& p) { lo = glm::min(lo, p), hi = glm::max(hi, p); }
  void extend(const Box& b) { lo = glm::min(lo, b.lo), hi = glm::max(hi, b.hi); }
  Vec3 centre() const { return 0.5 * lo + 0.5 * hi; }
  Vec3 corner(int i) const { return {i & 1 ? hi.x : lo.x, i & 2 ? hi.y : lo.y, i & 4 ? hi.z : lo.z}; }
};

}  // namespace tilecast
