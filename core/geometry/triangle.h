// The exact ray-triangle test, by barycentric coordinates.
//
// Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013: each vertex is sheared into ray
// space by a function of that vertex and the ray alone. The signs of three 2 x 2 determinants decide; here they are
// exact in float (base/exact.h, base/frame.h), and a symbolic shift of the ray decides where one is zero. So every ray
// crosses a closed mesh an even number of times, with signs that sum to zero.
//
// Float decides what is hit; the parameter and the barycentric coordinates then come from the same sum in double. Where
// double sees the line pass beside the triangle, by no more than float's rounding, the point of the triangle nearest to
// it stands for the hit. So the point lies on the triangle however thin that is.
#pragma once

#include "base/exact.h"
#include "base/frame.h"

namespace tilecast {

struct TriangleHit {
  double t;       // of the ray that entered the frame
  double u, v;    // weights of the second and third vertex
  bool entering;  // the ray goes against the normal (b - a) x (c - a)
};

// A triangle's vertices in frame coordinates.
struct Triangle {
  Vec3f a, b, c;
};

// The weights of the point of a triangle's outline that is nearest to the origin, in the plane. Rare.
struct Outline {
  double x[3], y[3];
};
[[gnu::cold, gnu::noinline]] inline Vec3 nearest_on_outline(Outline corners) {
  const auto& [x, y] = corners;
  Vec3 w(0.0);
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    int j = (i + 1) % 3;
    double ex = x[j] - x[i], ey = y[j] - y[i], length2 = ex * ex + ey * ey;
    double along = length2 > 0.0 ? std::clamp(-(x[i] * ex + y[i] * ey) / length2, 0.0, 1.0) : 0.0;
    double px = std::fma(along, ex, x[i]), py = std::fma(along, ey, y[i]);
    double distance2 = px * px + py * py;
    if (!(distance2 < least)) continue;
    least = distance2;
    w[i] = 1.0 - along, w[j] = along, w[(i + 2) % 3] = 0.0;
  }
  return w;
}

// A line in double, its coordinates in the order x, y, z of the ray's shear.
struct ShearedLine {
  double origin[3];
  double shear_x, shear_y;
  double along;  // the direction's largest component
  double t_start, t_scale;
};

inline ShearedLine sheared(const FrameRay& ray) {
  const double *origin = &ray.origin64.x, *direction = &ray.direction64.x;
  return {{origin[ray.x], origin[ray.y], origin[ray.z]}, ray.shear_x64, ray.shear_y64, direction[ray.z], ray.t_start, ray.t_scale};
}

// vertices: in the same order of coordinates. Inlined, so that most callers divide for u and v only where t is wanted.
[[gnu::always_inline]] inline TriangleHit refine(const ShearedLine& line, const float vertices[3][3], bool entering) {
  double x[3], y[3], z[3];
  for (int i = 0; i < 3; ++i) {
    z[i] = vertices[i][2] - line.origin[2];
    x[i] = std::fma(-line.shear_x, z[i], vertices[i][0] - line.origin[0]);
    y[i] = std::fma(-line.shear_y, z[i], vertices[i][1] - line.origin[1]);
  }
  double w[3];
  for (int i = 0; i < 3; ++i) {
    int j = (i + 1) % 3, k = (i + 2) % 3;
    w[i] = difference_of_products(x[j], y[k], y[j], x[k]);
  }
  double sum = w[0] + w[1] + w[2];
  bool within = std::min({w[0], w[1], w[2]}) >= 0.0 || std::max({w[0], w[1], w[2]}) <= 0.0;
  if (!within || sum == 0.0) [[unlikely]] {
    const Vec3 nearest = nearest_on_outline({{x[0], x[1], x[2]}, {y[0], y[1], y[2]}});
    for (int i = 0; i < 3; ++i) w[i] = nearest[i];
    sum = 1.0;
  }
  double s = (w[0] * z[0] + w[1] * z[1] + w[2] * z[2]) / sum / line.along;
  return {(line.t_start + s) * line.t_scale, w[1] / sum, w[2] / sum, entering};
}

// From which side a line crosses a triangle, both in the order of coordinates of the ray's shear: above 0 from behind,
// below 0 from the front, 0: not at all.
inline int crossed_side(const float origin[3], float shear_x, float shear_y, const float vertices[3][3]) {
  float x[3], y[3];
  for (int i = 0; i < 3; ++i) {
    float z = vertices[i][2] - origin[2];
    x[i] = std::fma(-shear_x, z, vertices[i][0] - origin[0]);
    y[i] = std::fma(-shear_y, z, vertices[i][1] - origin[1]);
  }
  int sa = edge_sign(x[1], y[1], x[2], y[2]);
  int sb = edge_sign(x[2], y[2], x[0], y[0]);
  if (sa * sb < 0) return 0;
  int sc = edge_sign(x[0], y[0], x[1], y[1]);
  if (sb * sc < 0 || sc * sa < 0) return 0;
  return sa + sb + sc;
}

inline bool intersect(const FrameRay& ray, const Triangle& triangle, TriangleHit& hit) {
  const float* given[3] = {&triangle.a.x, &triangle.b.x, &triangle.c.x};
  const float origin[3] = {ray.origin[ray.x], ray.origin[ray.y], ray.origin[ray.z]};
  float vertices[3][3];
  for (int i = 0; i < 3; ++i)
    vertices[i][0] = given[i][ray.x], vertices[i][1] = given[i][ray.y], vertices[i][2] = given[i][ray.z];
  int side = crossed_side(origin, ray.shear_x, ray.shear_y, vertices);
  if (side == 0) return false;
  hit = refine(sheared(ray), vertices, side < 0);
  return true;
}

}  // namespace tilecast
