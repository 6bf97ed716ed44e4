// A scene of few rectangles, boxes and balls that scatter like chalk, mirror, or are of one clear glass, in tables: what paths
// through it are traced by four at a time (integrators/plain_paths.h). What a hit of a flat face means is looked up.
#pragma once

#include <optional>
#include <vector>

#include "base/double_lanes.h"
#include "scene/scene.h"

namespace tilecast {

struct PlainScene {
  static constexpr size_t kMostObjects = 16;  // all are asked, without boxes around them

  // A rectangle, a ball, or a box whose six faces follow each other.
  struct Shape {
    enum class Kind : uint8_t { Rectangle, Box, Ball } kind;
    // Each number in all lanes, as it is asked for in them.
    Double4 to_local[3][3];  // [coordinate]: what the components of a vector count for it
    Double4 origin[3];
    Double4 lo[3], hi[3];    // of a rectangle x and z alone
    double radius;           // of a ball
    int64_t face;
  };
  // In rows of four, as many are loaded at once.
  struct alignas(32) Face {
    struct Row {
      double m[3], offset;
    };
    Row to_local[3], to_world[3];  // to_local: what is taken away first
    double normal[3], stretch;     // outward, world space
    double reflectance[3], leaf_error;  // leaf_error: of a point, relative to its coordinates
    uint64_t across[3];            // all bits: the coordinate in which the face lies,
    double offsets;
    double plane[3];               // and where
    double area;                   // of the light that it is; 0: of none that is sampled
    double emission[3], emits;     // emits: 1 or 0
    // What chalk alone does not ask for. All bits or none: a mirror, of glass, and a ball's, of this radius.
    uint64_t mirror, glass, round;
    double radius;
    uint64_t turned[4];            // all bits: Instance::turned
  };
  static constexpr int kRows = sizeof(Face) / (4 * sizeof(double));

  // The one light, if any is sampled.
  struct Lamp {
    Vec3 origin, edge1, edge2, normal, end;  // end: from a point of it to where shadow rays end
    double area, probability;
    Rgb radiance;
  };

  std::vector<Shape> shapes;  // in the order of their primitives
  std::vector<Face> faces;
  std::optional<Lamp> lamp;
  const Material* glass = nullptr;  // of all that refracts
  bool chalk = true;                // all of it, and flat

  // Nothing where the scene is not of this kind.
  static std::optional<PlainScene> of(const Scene& scene);
};

}  // namespace tilecast
