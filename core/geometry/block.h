// The axis-aligned box. Faces: 2 * axis, + 1 at the upper end.
#pragma once

#include "base/box.h"
#include "base/check.h"
#include "geometry/interval.h"

namespace tilecast {

struct Block {
  static constexpr int kFaces = 6;
  Vec3 lo{-1.0}, hi{1.0};
};

inline void check(const Block& b) {
  if (!(max_abs(b.lo) <= kLongest && max_abs(b.hi) <= kLongest && is_finite(b.lo) && is_finite(b.hi)))
    throw Error("min, max: must be finite and at most 1e100");
  for (int i = 0; i < 3; ++i)
    if (!(b.lo[i] < b.hi[i]))
      throw Error("max[" + std::to_string(i) + "]: must be greater than min, got " + text(b.lo[i]) + " and " +
                  text(b.hi[i]));
}
inline Box bounds(const Block& b) { return {b.lo, b.hi}; }

// Faces are numbered from `first_face`.
inline Interval inside_block(const Vec3& lo, const Vec3& hi, const Ray& line, int first_face) {
  const Vec3 &o = line.origin, &d = line.direction;
  Interval interval;
  for (int i = 0, face = first_face; i < 3; ++i, face += 2)
    interval.intersect(inside_slab(o[i], d[i], lo[i], hi[i], face, face + 1));
  return interval;
}
inline Vec3 block_outward(int face) {
  Vec3 n{0.0};
  n[face / 2] = face & 1 ? 1.0 : -1.0;
  return n;
}
inline Vec3 block_project(const Vec3& lo, const Vec3& hi, int face, Vec3 p) {
  p[face / 2] = face & 1 ? hi[face / 2] : lo[face / 2];
  return p;
}

inline Interval inside(const Block& b, const Ray& line) { return inside_block(b.lo, b.hi, line, 0); }
inline Vec3 outward(const Block&, int face, const Vec3&) { return block_outward(face); }
inline Vec3 project(const Block& b, int face, const Vec3& p) { return block_project(b.lo, b.hi, face, p); }

}  // namespace tilecast
