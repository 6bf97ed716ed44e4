#include "geometry/sure_lanes.h"

#include "geometry/ball_lanes.h"

namespace tilecast {
namespace {

constexpr uint32_t kAllLanes = (1u << kLanes) - 1;

struct LatestLanes {
  int number;
  Double8& t;
  Double8 face = 0.0;
  uint32_t good = kAllLanes;

  void offer(const Double8& at, const Mask8d& meant, const Double8& face_there) {
    const Mask8d better = meant & (number == 0 ? at > t : at < t);
    t = choose(better, at, t), face = choose(better, face_there, face);
  }
  void slab(const Double8& o, const Double8& d, double lo, double hi, int low_face) {
    const Mask8d up = d > 0.0, high = number == 1 ? up : ~up;
    const Double8 at = (choose(high, hi, lo) - o) / d;
    offer(at, ~(d == 0.0), choose(high, low_face + 1, low_face));
  }
  template <int n>
  void ball(const Double8 (&origin)[n], const Double8 (&direction)[n], double r) {
    const NearOneLanes<Double8, n> near(origin, direction, r);
    const BallRoots<Double8> roots(near);
    const Mask8d over_a = number == 1 ? roots.q > 0.0 : ~(roots.q > 0.0);
    const Double8 zero = choose(over_a, roots.q, roots.c.value()) / choose(over_a, roots.a.value(), roots.q);
    good &= bits(roots.meets | near.still);
    offer(zero * near.unit, roots.meets & ~near.still, 0.0);
  }
};

struct AheadLanes {
  Mask8d yes, no;
};

AheadLanes slab_ahead(const Double8& o, const Double8& d, double lo, double hi, int number) {
  const Mask8d up = d > 0.0, high = number == 1 ? up : ~up, level = d == 0.0;
  const Double8 to = choose(high, hi, lo) - o;
  const Mask8d sure = (abs(to) > kShortest) & (abs(d) < kLongest) & ~level;
  const Mask8d ahead = (to > 0.0) == up;
  AheadLanes out{sure & ahead, sure & ~ahead};
  (number == 0 ? out.no : out.yes) = (number == 0 ? out.no : out.yes) | level;
  return out;
}

template <int n>
AheadLanes ball_ahead(const Double8 (&origin)[n], const Double8 (&direction)[n], double r, int number) {
  const NearOneLanes<Double8, n> near(origin, direction, r);
  Double8 b = near.o[0] * near.d[0], farthest = abs(near.o[0]);
  for (int i = 1; i < n; ++i) b = b + near.o[i] * near.d[i], farthest = max(farthest, abs(near.o[i]));
  const Mask8d sure = (abs(b) > farthest * 0x1p-48) & (near.unit > kShortest) & ~near.still;
  const Mask8d over_a = number == 0 ? b > 0.0 : b < 0.0;
  const Double8 c = twofold_square(near.o, near.radius).value();
  const Mask8d by_c = sure & ~over_a & (abs(c) > kShortest), ahead = number == 0 ? c > 0.0 : c < 0.0;
  const Mask8d by_a = near.still | (sure & over_a);
  AheadLanes out{by_c & ahead, by_c & ~ahead};
  (number == 0 ? out.no : out.yes) = (number == 0 ? out.no : out.yes) | by_a;
  return out;
}

// The later of two entries, the earlier of two exits.
AheadLanes both(const AheadLanes& a, const AheadLanes& b, int number) {
  if (number == 0) return {a.yes | b.yes, a.no & b.no};
  return {a.yes & b.yes, a.no | b.no};
}

}  // namespace

bool has_sure_lanes(const Solid& solid) {
  return std::holds_alternative<Sphere>(solid) || std::holds_alternative<Block>(solid) ||
         std::holds_alternative<Cylinder>(solid);
}

uint32_t sure_crossings(const Solid& solid, const LineLanes& lines, int number, Double8& t, int32_t face[kLanes]) {
  const auto &o = lines.origin, &d = lines.direction;
  t = Double8(number == 0 ? -kInfinity : kInfinity);
  LatestLanes latest{number, t};
  if (auto* sphere = std::get_if<Sphere>(&solid)) {
    latest.ball(o, d, sphere->radius);
  } else if (auto* block = std::get_if<Block>(&solid)) {
    for (int i = 0; i < 3; ++i) latest.slab(o[i], d[i], block->lo[i], block->hi[i], 2 * i);
  } else {
    const Cylinder& cylinder = std::get<Cylinder>(solid);
    latest.slab(o[1], d[1], -0.5 * cylinder.height, 0.5 * cylinder.height, 1);
    latest.ball({o[0], o[2]}, {d[0], d[2]}, cylinder.radius);
  }
  for (int lane = 0; lane < kLanes; ++lane) face[lane] = static_cast<int32_t>(latest.face[lane]);
  return latest.good & bits(abs(t) < kInfinity);
}

SurelyAhead sure_crossings_ahead(const Solid& solid, const LineLanes& lines, int number) {
  const auto &o = lines.origin, &d = lines.direction;
  AheadLanes ahead;
  if (auto* sphere = std::get_if<Sphere>(&solid)) {
    ahead = ball_ahead(o, d, sphere->radius, number);
  } else if (auto* block = std::get_if<Block>(&solid)) {
    ahead = slab_ahead(o[0], d[0], block->lo[0], block->hi[0], number);
    for (int i = 1; i < 3; ++i) ahead = both(ahead, slab_ahead(o[i], d[i], block->lo[i], block->hi[i], number), number);
  } else {
    const Cylinder& cylinder = std::get<Cylinder>(solid);
    ahead = both(slab_ahead(o[1], d[1], -0.5 * cylinder.height, 0.5 * cylinder.height, number),
                 ball_ahead<2>({o[0], o[2]}, {d[0], d[2]}, cylinder.radius, number), number);
  }
  return {bits(ahead.yes), bits(ahead.no)};
}

}  // namespace tilecast
