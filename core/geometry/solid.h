// The solids, each as the intervals in which a whole line is inside it, in double.
//
// A solid is centred at the origin of its own space or brings its own place. Each has a file with what it is, what it
// refuses (`check`), its `bounds`, where a line is `inside` it, and, for a point of one of its faces, the way `outward`
// and how to `project` a point near by onto it. Quadratics are solved to the last digits (quadratic.h), so are the
// torus's quartics (torus.h); no constant here is a distance below which something is taken for zero.
#pragma once

#include <variant>

#include "geometry/block.h"
#include "geometry/capsule.h"
#include "geometry/cone.h"
#include "geometry/cylinder.h"
#include "geometry/halfspace.h"
#include "geometry/quadric.h"
#include "geometry/rounded_block.h"
#include "geometry/sphere.h"
#include "geometry/torus.h"

namespace tilecast {

using Solid = std::variant<Sphere, Block, Cylinder, Cone, Capsule, Torus, RoundedBlock, Quadric, Halfspace>;

// Throws Error where a parameter cannot be.
void check(const Solid& solid);

// All crossings of the whole line, sorted, entries and exits in turn. Returns how many.
int crossings(const Solid& solid, const Ray& line, SolidCrossing out[kMaxSolidCrossings]);

// Outward, of any length, at a point of the given face.
Vec3 outward(const Solid& solid, int face, const Vec3& p);

// A point near the face moved onto it.
Vec3 project(const Solid& solid, int face, const Vec3& p);

// Bound on the distance of a projected point from the face.
double projection_error(const Solid& solid, const Vec3& p);

Box bounds(const Solid& solid);
int face_count(const Solid& solid);

}  // namespace tilecast
