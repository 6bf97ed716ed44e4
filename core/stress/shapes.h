// Solids of every kind and size, and lines that come at them in awkward ways.
#pragma once

#include "geometry/solid.h"
#include "stress/meshes.h"

namespace tilecast::stress {

inline Quadric random_quadric(Random& random, double scale) {
  static constexpr std::array<double, 10> kNamed[] = {
      {1, 1, 1, 0, 0, 0, 0, 0, 0, -1},         // ball
      {1, -1, 1, 0, 0, 0, 0, 0, 0, -0.1},      // hyperboloid of one sheet
      {-1, 1, -1, 0, 0, 0, 0, 0, 0, -0.1},     // outside of it
      {1, -1, 1, 0, 0, 0, 0, 0, 0, 0.1},       // hyperboloid of two sheets
      {1, -1, 1, 0, 0, 0, 0, 0, 0, 0},         // double cone
      {1, 0, 1, 0, 0, 0, 0, -1, 0, -0.5},      // paraboloid
      {1, 0, -1, 0, 0, 0, 0, -1, 0, 0},        // saddle
      {0, 0, 0, 1, 0, 0, 0, 0, 0, 0},          // two wedges
      {1, 0, 1, 0, 0, 0, 0, 0, 0, -0.25},      // cylinder
      {0, 0, 0, 0, 0, 0, 1, 2, 3, -0.5}};      // halfspace
  std::array<double, 10> c = kNamed[random() % std::size(kNamed)];
  if (random() % 3 == 0)
    for (double& x : c) x = uniform(random, -1, 1);
  for (int i = 0; i < 10; ++i) c[i] *= i < 6 ? 1.0 : i < 9 ? scale : scale * scale;
  Vec3 lo = -scale * Vec3(1.0, uniform(random, 0.1, 2), 1.0), hi = scale * Vec3(1.0, 1.5, uniform(random, 0.1, 2));
  return Quadric::of(c, lo, hi);
}

inline constexpr int kSolidKinds = std::variant_size_v<Solid>;

// Sizes 1e-6 .. 1e6, ratios of sizes up to 1e3.
inline Solid random_solid(int kind, Random& random) {
  double scale = power_of_ten(random, -6, 6), ratio = power_of_ten(random, -3, 0);
  double flip = random() & 1 ? ratio : 1.0 / ratio;
  Vec3 lo = -scale * Vec3(1.0, uniform(random, -0.9, 2), ratio), hi = scale * Vec3(uniform(random, -0.9, 2), 1.0, ratio);
  switch (kind) {
    case 0: return Sphere{scale};
    case 1: return Block{lo, hi};
    case 2: return Cylinder{scale, scale * flip};
    case 3: {
      double tops[] = {0.0, flip, uniform(random, 0, 1)};
      return Cone{scale, scale * tops[random() % 3], scale * uniform(random, 0.1, 4)};
    }
    case 4: return Capsule{scale, scale * flip};
    case 5: return Torus{scale, random() & 7 ? scale * ratio : scale};
    case 6: {
      Vec3 size = hi - lo;
      double most = 0.5 * std::min({size.x, size.y, size.z});
      return RoundedBlock{lo, hi, random() & 3 ? most * uniform(random, 0.01, 0.99) : most};
    }
    case 7: return random_quadric(random, scale);
    default: {
      Halfspace h = Halfspace::of(random_direction(random), 0.5 * uniform(random, -scale, scale));
      h.lo = lo, h.hi = hi;
      return h;
    }
  }
}

// Where tracers crack: a point of a rim, a seam, an apex, an edge or a corner.
inline Vec3 awkward_point(const Solid& solid, Random& random) {
  Vec2 around(1.0, 0.0);
  if (random() & 3) {
    Vec3 direction = random_direction(random);
    around = glm::normalize(Vec2(direction.x, direction.z));
  }
  double side = random() & 1 ? 0.5 : -0.5;
  auto ring = [&](double radius, double y) { return Vec3(radius * around.x, y, radius * around.y); };
  if (auto* c = std::get_if<Cylinder>(&solid)) return ring(c->radius, side * c->height);
  if (auto* c = std::get_if<Cone>(&solid)) return ring(side < 0.0 ? c->radius : c->top_radius, side * c->height);
  if (auto* c = std::get_if<Capsule>(&solid))
    return random() & 1 ? ring(c->radius, side * c->height) : ring(0.0, side * (c->height + 2.0 * c->radius));
  if (auto* t = std::get_if<Torus>(&solid)) {
    double aside = 2.0 * side * t->minor_radius;
    return random() & 1 ? ring(t->radius, aside) : ring(t->radius + aside, 0.0);
  }
  Box box = bounds(solid);
  if (auto* b = std::get_if<RoundedBlock>(&solid)) {  // where flat turns round
    box.lo += b->radius, box.hi -= b->radius;
  }
  if (std::holds_alternative<Quadric>(solid) && random() & 1) return Vec3(0.0);
  if (std::holds_alternative<Sphere>(solid)) return max_abs(box.hi) * random_direction(random);
  Vec3 p = box.corner(random() % 8), q = box.corner(random() % 8);
  if (random() & 1) return p;
  int axis = random() % 3;
  p[axis] = p[axis] + uniform(random, 0, 1) * (q[axis] - p[axis]);
  if (auto* b = std::get_if<RoundedBlock>(&solid)) {
    axis = random() % 3;
    p[axis] += p[axis] < box.centre()[axis] ? -b->radius : b->radius;
  }
  return p;
}

// A line through or near the point, from up to 1e4 sizes away; at times along an axis, or starting on the point.
inline Ray line_at(const Vec3& target, double size, Random& random) {
  Vec3 direction = random_direction(random);
  if (random() % 4 == 0) {
    int axis = random() % 3;
    direction[axis] = 0.0;
    if (random() & 1) direction[(axis + 1) % 3] = 0.0;
  }
  if (max_abs(direction) == 0.0) direction.x = 1.0;
  Ray line{target, direction * power_of_ten(random, -3, 3)};
  if (random() % 8) line.origin -= size * power_of_ten(random, -1, 4) * direction;
  return line;
}

inline double size_of(const Solid& solid) {
  Box box = bounds(solid);
  return max_component(box.hi - box.lo);
}

}  // namespace tilecast::stress
