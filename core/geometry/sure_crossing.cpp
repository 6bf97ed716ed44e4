#include "geometry/sure_crossing.h"

#include "geometry/ball.h"

namespace tilecast {
namespace {

// The later of the entries and the earlier of the exits count; of those at one place the first that is offered.
struct Latest {
  int number;
  SolidCrossing& out;

  void offer(double t, int face) {
    if (number == 0 ? t > out.t : t < out.t) out.t = t, out.face = face;
  }
  void slab(double o, double d, double lo, double hi, int low_face) {
    if (d == 0.0) return;
    const bool high = (d > 0.0) == (number == 1);
    offer(((high ? hi : lo) - o) / d, low_face + high);
  }
  template <class V>
  bool ball(const V& origin, const V& direction, double r) {
    const NearOne<V> near(origin, direction, r);
    if (near.still) return true;
    const Twofold a = twofold_dot(near.d, near.d), b = twofold_dot(near.o, near.d);
    double zero;
    if (!solve_one(a, b, twofold_square(near.o, near.radius), number == 1, zero)) return false;
    offer(zero * near.unit, 0);
    return true;
  }
};

enum class Ahead : uint8_t { No, Yes, Unsure };

// t = (end - o) / d
Ahead slab_ahead(double o, double d, double lo, double hi, int number) {
  if (d == 0.0) return number == 0 ? Ahead::No : Ahead::Yes;
  const double to = ((d > 0.0) == (number == 1) ? hi : lo) - o;
  if (!(std::fabs(to) > kShortest && std::fabs(d) < kLongest)) return Ahead::Unsure;  // t may be too small for a double
  return (to > 0.0) == (d > 0.0) ? Ahead::Yes : Ahead::No;
}

// The zeros are q / a and c / q, and q has the other sign than b.
template <class V>
Ahead ball_ahead(const V& origin, const V& direction, double r, int number) {
  const NearOne<V> near(origin, direction, r);
  if (near.still) return number == 0 ? Ahead::No : Ahead::Yes;
  const double b = glm::dot(near.o, near.d);
  if (!(std::fabs(b) > 0x1p-48 * max_abs(near.o) && near.unit > kShortest)) return Ahead::Unsure;
  if (number == 0 ? b > 0.0 : b < 0.0) return number == 0 ? Ahead::No : Ahead::Yes;  // q / a
  const double c = twofold_square(near.o, near.radius).value();
  if (!(std::fabs(c) > kShortest)) return Ahead::Unsure;
  return (number == 0 ? c > 0.0 : c < 0.0) ? Ahead::Yes : Ahead::No;
}

// The later of two entries, the earlier of two exits.
Ahead both(Ahead a, Ahead b, int number) {
  const Ahead decides = number == 0 ? Ahead::Yes : Ahead::No;
  if (a == decides || b == decides) return decides;
  return a == Ahead::Unsure || b == Ahead::Unsure ? Ahead::Unsure : a;
}

}  // namespace

bool sure_crossing(const Solid& solid, const Ray& line, int number, SolidCrossing& out) {
  const Vec3 &o = line.origin, &d = line.direction;
  out = {number == 0 ? -kInfinity : kInfinity, 0.0, 0, number == 0};
  Latest latest{number, out};
  if (auto* sphere = std::get_if<Sphere>(&solid)) {
    if (!latest.ball(o, d, sphere->radius)) return false;
  } else if (auto* block = std::get_if<Block>(&solid)) {
    for (int i = 0; i < 3; ++i) latest.slab(o[i], d[i], block->lo[i], block->hi[i], 2 * i);
  } else if (auto* cylinder = std::get_if<Cylinder>(&solid)) {
    latest.slab(o.y, d.y, -0.5 * cylinder->height, 0.5 * cylinder->height, 1);
    if (!latest.ball(Vec2(o.x, o.z), Vec2(d.x, d.z), cylinder->radius)) return false;
  } else {
    SolidCrossing list[kMaxSolidCrossings];
    if (crossings(solid, line, list) != 2) return false;
    out = list[number];
  }
  return std::isfinite(out.t);
}

std::optional<bool> sure_crossing_ahead(const Solid& solid, const Ray& line, int number) {
  const Vec3 &o = line.origin, &d = line.direction;
  Ahead ahead = Ahead::Unsure;
  if (auto* sphere = std::get_if<Sphere>(&solid)) {
    ahead = ball_ahead(o, d, sphere->radius, number);
  } else if (auto* block = std::get_if<Block>(&solid)) {
    ahead = slab_ahead(o.x, d.x, block->lo.x, block->hi.x, number);
    for (int i = 1; i < 3; ++i) ahead = both(ahead, slab_ahead(o[i], d[i], block->lo[i], block->hi[i], number), number);
  } else if (auto* cylinder = std::get_if<Cylinder>(&solid)) {
    ahead = both(slab_ahead(o.y, d.y, -0.5 * cylinder->height, 0.5 * cylinder->height, number),
                 ball_ahead(Vec2(o.x, o.z), Vec2(d.x, d.z), cylinder->radius, number), number);
  }
  if (ahead == Ahead::Unsure) return std::nullopt;
  return ahead == Ahead::Yes;
}

}  // namespace tilecast
