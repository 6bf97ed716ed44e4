// Texture coordinates of solids and flat surfaces. Seen from outside, u grows to the right and v upwards, so that an image
// is never mirrored.
//
//   rectangle, disk     the square around it, as seen from +y with -z on top
//   box, rounded box,   each side shows the whole square; sides are upright, the top has -z on top, the bottom +z
//   quadric             (a rounded box or a quadric: by the largest component of the normal, over its box)
//   sphere, capsule     u is the longitude about +y, 0.5 at +z and 0.75 at +x; v goes from the lower to the upper pole in
//                       proportion to the length of the way
//   cylinder, cone      the side: u as above, v along the axis; bottom and top: as a disk
//   torus               u as above; v about the tube, 0.5 at the outside and 0.75 on top
//   halfspace           metres along its plane
#pragma once

#include "geometry/flat.h"
#include "geometry/solid.h"

namespace tilecast {

struct Parametrisation {
  Vec2 uv;
  Vec3 du{0.0}, dv{0.0};  // along the surface, the way in which u and v grow: of any length; 0 where there is none
};

// p: a point of the face, in the object's space.
Parametrisation parametrisation(const Solid& solid, int face, const Vec3& p);
Parametrisation parametrisation(const Flat& flat, const Vec3& p);

}  // namespace tilecast
