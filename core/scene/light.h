// Lights as the integrators sample them.
//
// They are numbered through: points, spots, areas; then those that are far away, directional ones and the environment. Each
// of the latter is chosen as often as all others together. Of these, one of a few is chosen by its power, one of many by
// a tree (see light_tree.h), whose choice depends on the place that is lit.
#pragma once

#include <memory>
#include <vector>

#include "base/affine.h"
#include "scene/environment.h"
#include "scene/light_tree.h"

namespace tilecast {

struct PointLight {
  Vec3 position;
  Rgb intensity;  // radiant intensity, W/sr
};

// Full intensity up to the inner angle, none from the outer one on, smooth between them.
struct SpotLight {
  Vec3 position;
  Vec3 direction;  // of its axis, unit length
  Rgb intensity;   // along the axis, W/sr
  double cos_inner, cos_outer;

  // The share of the intensity at an angle to the axis.
  double falloff(double cosine) const {
    if (cosine <= cos_outer) return 0.0;
    if (cosine >= cos_inner) return 1.0;
    const double x = (cosine - cos_outer) / (cos_inner - cos_outer);
    return x * x * (3.0 - 2.0 * x);
  }
};

// Parallel light from far away: the sun.
struct DirectionalLight {
  Vec3 direction;  // in which the light goes, unit length
  Rgb irradiance;  // on a surface that it meets head on, W/m^2
};

// Pieces that emit from their front, with a common radiance: one emitting rectangle, disk, ball or mesh of the scene.
// Points are uniform over the area, but for a ball, which is sampled by the solid angle under which it is seen.
struct AreaLight {
  enum class Shape : uint8_t { Parallelogram, Triangle, Ellipse, Ball };
  struct Piece {
    Vec3 origin, edge1, edge2;  // world space; of an ellipse the centre and two conjugate radii, of a ball one radius
  };
  std::vector<Piece> pieces;
  std::vector<double> cumulative;  // area of the pieces up to and with this one
  Shape shape = Shape::Parallelogram;  // of all pieces
  double sideways = 0.0;           // how far beside a piece a ray may still meet it, metres: a mesh's
  double flip = 1.0;               // -1 where cross(edge1, edge2) points to the back
  Rgb radiance;
  int refracting = -1;             // number of its material, where light goes through that
  uint64_t first_primitive = 0, primitives = 0;

  double area() const { return cumulative.back(); }
  double radius() const { return glm::length(pieces[0].edge1); }  // of a ball
  LightBounds bounds() const;
};

// A light and the probability with which it was chosen; 0: none of them can light the place.
struct LightChoice {
  size_t light = 0;
  double probability = 0.0;
};

struct Lights {
  std::vector<PointLight> points;
  std::vector<SpotLight> spots;
  std::vector<AreaLight> areas;  // sorted by first_primitive
  std::vector<DirectionalLight> directionals;
  std::shared_ptr<const Environment> environment;  // null: the background is the same all around

  size_t first_spot() const { return points.size(); }
  size_t first_area() const { return first_spot() + spots.size(); }
  size_t first_directional() const { return first_area() + areas.size(); }
  size_t environment_number() const { return first_directional() + directionals.size(); }
  size_t count() const { return count_; }

  // Counts them, and makes what choosing needs.
  void finish();
  LightChoice choose(double u, const LitPlace& place) const;
  // The probability with which choose() takes the light.
  double probability(size_t light, const LitPlace& place) const;
  // The area light that a primitive belongs to, or -1.
  int find(uint64_t primitive) const;
  bool has_tree() const { return !tree_.empty(); }

 private:
  size_t count_ = 0;                // asked for at every hit
  std::vector<double> cumulative_;  // power up to and with this light of those at a place, where they have no tree
  LightTree tree_;
  double share_ = 1.0;              // the probability of each that is far away, and of all others together
};

struct LightSample {
  Vec3 point;
  Vec3 normal;    // unit length
  double error;   // bound on the error of the point, metres
};

// A point of any area light but a ball, uniform over its area.
LightSample sample(const AreaLight& light, double u_piece, const Vec2& u);

}  // namespace tilecast
