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

// The weights of the point of a triangle's outline that is nearest to the origin, in the plane.
inline void nearest_on_outline(const double x[3], const double y[3], double w[3]) {
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
}

inline TriangleHit refine(const FrameRay& ray, const Triangle& triangle, bool entering) {
  Vec3 p[3] = {Vec3(triangle.a) - ray.origin64, Vec3(triangle.b) - ray.origin64, Vec3(triangle.c) - ray.origin64};
  double x[3], y[3];
  for (int i = 0; i < 3; ++i) {
    x[i] = std::fma(-ray.shear_x64, p[i][ray.z], p[i][ray.x]);
    y[i] = std::fma(-ray.shear_y64, p[i][ray.z], p[i][ray.y]);
  }
  double w[3];
  for (int i = 0; i < 3; ++i) {
    int j = (i + 1) % 3, k = (i + 2) % 3;
    w[i] = difference_of_products(x[j], y[k], y[j], x[k]);
  }
  double sum = w[0] + w[1] + w[2];
  bool within = (w[0] >= 0.0 && w[1] >= 0.0 && w[2] >= 0.0) || (w[0] <= 0.0 && w[1] <= 0.0 && w[2] <= 0.0);
  if (!within || sum == 0.0) {
    nearest_on_outline(x, y, w);
    sum = 1.0;
  }
  double z = (w[0] * p[0][ray.z] + w[1] * p[1][ray.z] + w[2] * p[2][ray.z]) / sum;
  double s = z / ray.direction64[ray.z];
  return {(ray.t_start + s) * ray.t_scale, w[1] / sum, w[2] / sum, entering};
}

inline bool intersect(const FrameRay& ray, const Triangle& triangle, TriangleHit& hit) {
  const float* vertices[3] = {&triangle.a.x, &triangle.b.x, &triangle.c.x};
  float x[3], y[3];
  for (int i = 0; i < 3; ++i) {
    float z = vertices[i][ray.z] - ray.origin[ray.z];
    x[i] = std::fma(-ray.shear_x, z, vertices[i][ray.x] - ray.origin[ray.x]);
    y[i] = std::fma(-ray.shear_y, z, vertices[i][ray.y] - ray.origin[ray.y]);
  }
  int sa = edge_sign(x[1], y[1], x[2], y[2]);
  int sb = edge_sign(x[2], y[2], x[0], y[0]);
  if (sa * sb < 0) return false;
  int sc = edge_sign(x[0], y[0], x[1], y[1]);
  if (sb * sc < 0 || sc * sa < 0) return false;
  int side = sa + sb + sc;
  if (side == 0) return false;
  hit = refine(ray, triangle, side < 0);
  return true;
}

}  // namespace tilecast
