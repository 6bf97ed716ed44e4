// Float coordinates in which nothing overflows, underflows or loses its place.
//
// A Frame moves its content about the origin and scales it by a power of two (exactly) so that it fits [-1, 1]^3.
// Vertices lie on a grid of 2^-36 there. A ray is carried in double, and only its part near the content is rounded to
// float: the origin becomes the point closest to the frame's centre, the direction gets its largest component into
// [1, 2). Then, for every vertex and every ray, products of two sheared coordinates are multiples of 2^-144, inside
// the range of float (2^-149), and the determinants of base/exact.h have exact signs. A scene scaled by 2^k gives the
// same floats.
//
// kBoxPadding covers, in units of the frame, what separates a box test in float from the intersection in double:
// rounding of the slab test (12 u), of the ray (6 u) and of the shear (6 u), u = 2^-24. Boxes padded by it never cull
// a triangle that the triangle test accepts (compare Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013).
#pragma once

#include "base/box.h"
#include "base/ray.h"

#include <bit>

namespace tilecast {

inline constexpr float kBoxPadding = 0x1p-19f;
inline constexpr double kGrid = 0x1p-36;

// Rounds to a multiple of 2^-36, then to float.
inline float to_grid(double x) { return static_cast<float>(std::rint(x * (1.0 / kGrid)) * kGrid); }

// 2^e and 2^-e for a normal number in [2^e, 2^(e + 1)), with e in [-1022, 1022].
inline double power_below(double x) {
  return std::bit_cast<double>(std::bit_cast<uint64_t>(x) & (uint64_t(0x7ff) << 52));
}
inline double power_below_reciprocal(double x) {
  uint64_t exponent = (std::bit_cast<uint64_t>(x) >> 52) & 0x7ff;
  return std::bit_cast<double>((0x7fe - exponent) << 52);
}

struct Frame {
  Vec3 centre{0.0};
  double scale = 1.0;  // metres per unit, a power of two
  double per_metre = 1.0;  // 1 / scale, exact

  static Frame around(const Box& box) {
    Frame frame;
    if (box.empty()) return frame;
    frame.centre = box.centre();
    double half = std::max(max_abs(box.hi - frame.centre), max_abs(box.lo - frame.centre));
    if (half > 0.0 && std::isfinite(half)) frame.scale = std::ldexp(1.0, std::ilogb(half) + 1);
    frame.scale = std::clamp(frame.scale, 0x1p-500, 0x1p500);
    frame.per_metre = 1.0 / frame.scale;
    return frame;
  }

  Vec3 to_frame(const Vec3& p) const { return (p - centre) * per_metre; }
  Vec3 from_frame(const Vec3& p) const { return centre + scale * p; }
  // How far beside a triangle the float test may still see a hit, metres.
  double sideways_error() const { return 0x1p-22 * scale; }
};

// The line of a ray in a frame, in double and rounded to float. Parameters: t of the ray = (t_start + s) * t_scale,
// where s counts from the point closest to the frame's centre.
struct FrameRay {
  float origin[3], direction[3], reciprocal[3];
  int x, y, z;            // z: the largest component of the direction; x, y keep the winding
  float shear_x, shear_y;
  Vec3 origin64, direction64;  // before rounding
  double shear_x64, shear_y64;
  double t_start, t_scale, s_scale;  // s_scale = 1 / t_scale, both powers of two
  float slack;                       // in s: what the sums with t_start lose, far from the content

  // The ray's t as a parameter s in float, no less (no more) than it is; culling alone looks at it.
  float s_above(double t) const {
    float s = static_cast<float>(t * s_scale - t_start);
    return s + std::fabs(s) * 0x1p-22f + slack;
  }
  float s_below(double t) const {
    float s = static_cast<float>(t * s_scale - t_start);
    return s - std::fabs(s) * 0x1p-22f - slack;
  }
  // The ray's t at s, no more than it is.
  double t_below(float s) const { return (t_start + (s - std::fabs(s) * 0x1p-22f - slack)) * t_scale; }
};

// The line of a ray in a frame, in double; t of the ray = (t_start + s) * t_scale, as in FrameRay.
struct NearLine {
  Vec3 origin;            // of the ray
  Vec3 start, direction;  // the point closest to the frame's centre; the largest component in [1, 2)
  double t_start, t_scale, s_scale;
};

// False where the line passes the frame's content by, or is not finite.
inline bool enter_near(const Frame& frame, const Ray& ray, NearLine& out) {
  out.origin = frame.to_frame(ray.origin);
  double largest = max_abs(ray.direction);
  if (!(largest >= 0x1p-1000 && largest <= 0x1p1000)) return false;
  double normalise = power_below_reciprocal(largest);
  out.direction = ray.direction * normalise;
  out.t_scale = frame.scale * normalise;
  out.s_scale = frame.per_metre * power_below(largest);
  out.t_start = -glm::dot(out.origin, out.direction) / glm::dot(out.direction, out.direction);
  out.start = out.origin + out.t_start * out.direction;
  // Content lies within sqrt(3) of the centre; !(<=) also catches NaN.
  return glm::dot(out.start, out.start) <= 4.0;
}

// Finite, so that no product with it is NaN.
inline float slab_reciprocal(float d) { return 1.0f / (std::fabs(d) < 0x1p-40f ? std::copysign(0x1p-40f, d) : d); }

// What box tests look at; triangles need the rest.
inline bool enter_boxes(const Frame& frame, const Ray& ray, FrameRay& out) {
  NearLine line;
  if (!enter_near(frame, ray, line)) return false;
  out.t_scale = line.t_scale, out.s_scale = line.s_scale, out.t_start = line.t_start;
  out.slack = static_cast<float>(std::fabs(out.t_start) * 0x1p-50);
  out.origin64 = line.start;
  out.direction64 = line.direction;
  for (int i = 0; i < 3; ++i) {
    out.origin[i] = to_grid(line.start[i]);
    out.direction[i] = to_grid(line.direction[i]);
    out.reciprocal[i] = slab_reciprocal(out.direction[i]);
  }
  return true;
}

// False as enter_near is.
inline bool enter_frame(const Frame& frame, const Ray& ray, FrameRay& out) {
  if (!enter_boxes(frame, ray, out)) return false;
  const Vec3& direction = out.direction64;
  Vec3 a = glm::abs(direction);
  out.z = a.x >= a.y ? (a.x >= a.z ? 0 : 2) : (a.y >= a.z ? 1 : 2);
  out.x = (out.z + 1) % 3;
  out.y = (out.z + 2) % 3;
  if (direction[out.z] < 0.0) std::swap(out.x, out.y);
  out.shear_x = to_grid(double(out.direction[out.x]) / out.direction[out.z]);
  out.shear_y = to_grid(double(out.direction[out.y]) / out.direction[out.z]);
  out.shear_x64 = direction[out.x] / direction[out.z];
  out.shear_y64 = direction[out.y] / direction[out.z];
  return true;
}

}  // namespace tilecast
