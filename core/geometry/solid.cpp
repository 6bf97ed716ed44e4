#include "geometry/solid.h"

namespace tilecast {
namespace {

struct Interval {
  SolidCrossing enter{-kInfinity, 0.0, 0, true}, exit{kInfinity, 0.0, 0, false};
  bool empty = false;

  void intersect(const Interval& other) {
    empty = empty || other.empty;
    if (other.enter.t > enter.t) enter = other.enter;
    if (other.exit.t < exit.t) exit = other.exit;
    if (!(enter.t < exit.t)) empty = true;
  }
};

// Where o + t d lies within `radius` of the origin, in two or three dimensions.
template <class V>
Interval inside_ball(const V& o, const V& d, double radius) {
  Interval interval;
  double a = glm::dot(d, d);
  if (a == 0.0) {
    interval.empty = !(glm::dot(o, o) < radius * radius);
    return interval;
  }
  double b = -glm::dot(o, d);
  V nearest = o + (b / a) * d;
  double discriminant = radius * radius - glm::dot(nearest, nearest);
  if (!(discriminant > 0.0)) {
    interval.empty = true;
    return interval;
  }
  double root = std::sqrt(a * discriminant);
  double q = b + std::copysign(root, b);
  double near = (glm::dot(o, o) - radius * radius) / q, far = q / a;
  if (near > far) std::swap(near, far);
  // A displacement of the line moves t by its size over the cosine of the angle of incidence.
  double error = 8 * kUnitRoundoff * (std::sqrt(glm::dot(o, o)) + radius) * radius / root;
  interval.enter = {near, error, 0, true};
  interval.exit = {far, error, 0, false};
  return interval;
}

Interval inside_slab(double o, double d, double lo, double hi, int low_face, int high_face) {
  Interval interval;
  if (d == 0.0) {
    interval.empty = !(lo <= o && o < hi);  // half open: of two slabs side by side a line is in one
    return interval;
  }
  double low = (lo - o) / d, high = (hi - o) / d;
  double scale = 4 * kUnitRoundoff / std::fabs(d);
  SolidCrossing at_low{low, scale * (std::fabs(o) + std::fabs(lo)), low_face, d > 0.0};
  SolidCrossing at_high{high, scale * (std::fabs(o) + std::fabs(hi)), high_face, d < 0.0};
  interval.enter = d > 0.0 ? at_low : at_high;
  interval.exit = d > 0.0 ? at_high : at_low;
  return interval;
}

Interval inside(const Sphere& s, const Ray& line) { return inside_ball(line.origin, line.direction, s.radius); }

Interval inside(const Block& b, const Ray& line) {
  Interval interval;
  for (int i = 0; i < 3; ++i)
    interval.intersect(inside_slab(line.origin[i], line.direction[i], b.lo[i], b.hi[i], 2 * i, 2 * i + 1));
  return interval;
}

Interval inside(const Cylinder& c, const Ray& line) {
  Interval interval = inside_ball(Vec2(line.origin.x, line.origin.z), Vec2(line.direction.x, line.direction.z), c.radius);
  interval.intersect(inside_slab(line.origin.y, line.direction.y, -0.5 * c.height, 0.5 * c.height, 1, 2));
  return interval;
}

template <class... F>
struct Overload : F... {
  using F::operator()...;
};

}  // namespace

int crossings(const Solid& solid, const Ray& line, SolidCrossing out[kMaxSolidCrossings]) {
  Interval interval = std::visit([&](const auto& s) { return inside(s, line); }, solid);
  if (interval.empty || !std::isfinite(interval.enter.t) || !std::isfinite(interval.exit.t)) return 0;
  out[0] = interval.enter;
  out[1] = interval.exit;
  return 2;
}

Vec3 outward(const Solid& solid, int face, const Vec3& p) {
  return std::visit(Overload{[&](const Sphere&) { return p; },
                             [&](const Block&) {
                               Vec3 n{0.0};
                               n[face / 2] = face & 1 ? 1.0 : -1.0;
                               return n;
                             },
                             [&](const Cylinder&) {
                               return face == 0 ? Vec3(p.x, 0.0, p.z) : Vec3(0.0, face == 1 ? -1.0 : 1.0, 0.0);
                             }},
                    solid);
}

Vec3 project(const Solid& solid, int face, const Vec3& p) {
  return std::visit(Overload{[&](const Sphere& s) { return p * (s.radius / glm::length(p)); },
                             [&](const Block& b) {
                               Vec3 q = p;
                               q[face / 2] = face & 1 ? b.hi[face / 2] : b.lo[face / 2];
                               return q;
                             },
                             [&](const Cylinder& c) {
                               if (face != 0) return Vec3(p.x, face == 1 ? -0.5 * c.height : 0.5 * c.height, p.z);
                               double k = c.radius / std::sqrt(p.x * p.x + p.z * p.z);
                               return Vec3(p.x * k, p.y, p.z * k);
                             }},
                    solid);
}

Box bounds(const Solid& solid) {
  return std::visit(Overload{[](const Sphere& s) { return Box{Vec3(-s.radius), Vec3(s.radius)}; },
                             [](const Block& b) { return Box{b.lo, b.hi}; },
                             [](const Cylinder& c) {
                               Vec3 h{c.radius, 0.5 * c.height, c.radius};
                               return Box{-h, h};
                             }},
                    solid);
}

int face_count(const Solid& solid) {
  return std::visit(Overload{[](const Sphere&) { return 1; }, [](const Block&) { return 6; },
                             [](const Cylinder&) { return 3; }},
                    solid);
}

}  // namespace tilecast
