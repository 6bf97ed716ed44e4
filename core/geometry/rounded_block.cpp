#include "geometry/rounded_block.h"

#include "geometry/ball.h"
#include "geometry/block.h"

namespace tilecast {
namespace {

constexpr int kRound = 6;

Box inner(const RoundedBlock& b) {
  Box box{b.lo + b.radius, b.hi - b.radius};
  box.hi = glm::max(box.hi, box.lo);  // where the radius is half a side, rounding may take them past each other
  return box;
}

Vec3 arm_of(const RoundedBlock& b, const Vec3& p) {
  const Box core = inner(b);
  return p - glm::clamp(p, core.lo, core.hi);
}

}  // namespace

void check(const RoundedBlock& b) {
  check(Block{b.lo, b.hi});
  check_positive(b.radius, "radius");
  Vec3 size = b.hi - b.lo;
  double most = 0.5 * std::min({size.x, size.y, size.z});
  if (!(b.radius <= most))
    throw Error("radius: must be at most half the shortest side, " + text(most) + ", got " + text(b.radius));
}

Box bounds(const RoundedBlock& b) { return {b.lo, b.hi}; }

Interval inside(const RoundedBlock& b, const Ray& line) {
  const Vec3 &o = line.origin, &d = line.direction;
  Interval whole = Interval::nothing();
  const Interval box = inside_block(b.lo, b.hi, line, 0);
  if (box.empty) return whole;
  const Box core = inner(b);
  Interval slabs[3];
  const double farthest = std::max(max_abs(b.lo), max_abs(b.hi));
  // From the lower and the upper planes of the inner box, without the rounding of the sums.
  Twofold from[3][2];
  for (int i = 0; i < 3; ++i) {
    from[i][0] = two_sum(o[i], -b.lo[i]) + -b.radius;
    from[i][1] = two_sum(o[i], -b.hi[i]) + b.radius;
  }
  for (int i = 0; i < 3; ++i) slabs[i] = inside_slab(o[i], d[i], core.lo[i], core.hi[i], kRound, kRound);
  for (int i = 0; i < 3; ++i) {
    int j = (i + 1) % 3, k = (i + 2) % 3;
    Interval part = inside_slab(o[i], d[i], b.lo[i], b.hi[i], 2 * i, 2 * i + 1);
    part.intersect(slabs[j]);
    part.intersect(slabs[k]);
    whole.extend(part);
  }
  if (whole.enter.t == box.enter.t && whole.exit.t == box.exit.t) return whole;  // through flat faces
  for (int i = 0; i < 3; ++i) {
    int j = (i + 1) % 3, k = (i + 2) % 3;
    for (int side = 0; side < 4; ++side) {  // the edges along i
      const Twofold &u = from[j][side & 1], &v = from[k][side >> 1];
      Shift<Vec2> shift{Vec2(u.lo, v.lo), farthest};
      Interval edge = inside_ball(Vec2(u.hi, v.hi), Vec2(d[j], d[k]), b.radius, kRound, &shift);
      edge.intersect(slabs[i]);
      whole.extend(edge);
    }
  }
  for (int corner = 0; corner < 8; ++corner) {
    const Twofold &x = from[0][corner & 1], &y = from[1][corner >> 1 & 1], &z = from[2][corner >> 2];
    Shift<Vec3> shift{Vec3(x.lo, y.lo, z.lo), farthest};
    whole.extend(inside_ball(Vec3(x.hi, y.hi, z.hi), d, b.radius, kRound, &shift));
  }
  return whole;
}

Vec3 outward(const RoundedBlock& b, int face, const Vec3& p) {
  if (face != kRound) return block_outward(face);
  const Vec3 arm = direction_of(arm_of(b, p), Vec3(0.0));
  if (arm != Vec3(0.0)) return arm;
  int nearest = 0;  // p is beyond the core by less than its own last digit
  auto inwards = [&](int k) { return k & 1 ? b.hi[k / 2] - p[k / 2] : p[k / 2] - b.lo[k / 2]; };
  for (int k = 1; k < 6; ++k)
    if (inwards(k) < inwards(nearest)) nearest = k;
  return block_outward(nearest);
}

Vec3 project(const RoundedBlock& b, int face, const Vec3& p) {
  if (face != kRound) return block_project(b.lo, b.hi, face, p);
  Vec3 arm = arm_of(b, p);
  return p + (of_length(arm, b.radius, arm) - arm);
}

}  // namespace tilecast
