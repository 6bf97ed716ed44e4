// A torus about y. Up to four crossings.
//
// Along a line the torus is the sign of a quartic. The line's origin is first moved to the point closest to the centre;
// the coefficients are formed with twice the precision, since in a thin torus all digits of double cancel. Between the
// quartic's extrema, found through those of its derivatives, it is monotone: a root lies where the signs differ, and
// Newton's method inside that bracket brings it to the last digit. The signs at both outer ends are positive, so the
// number of crossings is even.
#pragma once

#include "base/box.h"
#include "geometry/interval.h"

namespace tilecast {

struct Torus {
  static constexpr int kFaces = 1;
  double radius = 1.0, minor_radius = 0.25;  // from the axis to the middle of the tube; of the tube
};

void check(const Torus& t);
Box bounds(const Torus& t);
Intervals inside(const Torus& t, const Ray& line);
Vec3 outward(const Torus& t, int face, const Vec3& p);
Vec3 project(const Torus& t, int face, const Vec3& p);

}  // namespace tilecast
