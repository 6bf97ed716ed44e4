// Lights as the integrators sample them.
#pragma once

#include <vector>

#include "base/affine.h"

namespace tilecast {

struct PointLight {
  Vec3 position;
  Rgb intensity;  // radiant intensity, W/sr
};

// Pieces that emit from their front, with a common radiance: one emitting rectangle, disk or mesh of the scene. Points are uniform over the area.
struct AreaLight {
  enum class Shape : uint8_t { Parallelogram, Triangle, Ellipse };
  struct Piece {
    Vec3 origin, edge1, edge2;  // world space; of an ellipse the centre and two conjugate radii
  };
  std::vector<Piece> pieces;
  std::vector<double> cumulative;  // area of the pieces up to and with this one
  Shape shape = Shape::Parallelogram;  // of all pieces
  double flip = 1.0;               // -1 where cross(edge1, edge2) points to the back
  Rgb radiance;
  uint64_t first_primitive = 0, primitives = 0;

  double area() const { return cumulative.back(); }
};

struct Lights {
  std::vector<PointLight> points;
  std::vector<AreaLight> areas;     // sorted by first_primitive
  std::vector<double> cumulative;   // power up to and with this light: points, then areas
  size_t count() const { return points.size() + areas.size(); }

  void finish();
  // The probability with which the light is chosen.
  double probability(size_t light) const;
  size_t choose(double u) const;
  // The area light that a primitive belongs to, or -1.
  int find(uint64_t primitive) const;
};

struct LightSample {
  Vec3 point;
  Vec3 normal;    // of an area light, unit length
  Rgb radiance;   // of an area light, from its front
  double error;   // bound on the error of the point, metres
};

LightSample sample(const AreaLight& light, double u_piece, const Vec2& u);

}  // namespace tilecast
