// A line in float against the operands of a CSG's filter: bounds on where it enters and leaves each.
#pragma once

#include "scene/csg.h"
#include "scene/float_line.h"

namespace tilecast {

// Displacements in units of the frame, in which the operands lie within [-1, 1]^3 and the part of the line that can
// meet them within |s| < 2, |direction| in [1, 2 sqrt 3). With e = 2^-24: origin 2e, direction 2e s, the maps'
// coefficients and their application to both 24e (rows of length 1; even balls have none), the solver's root 4e: below
// 2^-18 with the bounds of the exact crossings, which are 2^-24 at most (kFarthest, kCondition); twice that, and twice
// again.
inline constexpr double kDisplacement = 0x1p-16;
inline constexpr double kRelative = 0x1p-19;  // of a ball's radius, for the solver
inline constexpr double kFarthest = 0x1p16;   // of a line's origin, frame units
inline constexpr double kCondition = 0x1p8;   // of an operand's transform

inline constexpr size_t kMostFilterNodes = 32;

// Narrows s_min .. s_max to where the line is in the box.
inline void clip_to_box(const FrameBox& box, const FloatLine& line, float& s_min, float& s_max) {
  for (int i = 0; i < 3; ++i) {
    float per = line.reciprocal[i];
    float a = (box.lo[i] - line.origin[i]) * per, b = (box.hi[i] - line.origin[i]) * per;
    s_min = std::max(s_min, std::min(a, b));
    s_max = std::min(s_max, std::max(a, b));
  }
}

// Where a batch's operands can begin and end: bounds on each.
struct Ends {
  Float8 in[2], out[2];
};

// False where the line meets none of the balls. Even ones are looked at in the frame, others where they have radius 1.
inline bool meet_balls(const CsgFilter::Batch& batch, const FloatLine& line, Ends& ends) {
  Float8 o[3], d[3], b = all(0.0f), inverse, distance2 = all(0.0f);
  for (int i = 0; i < 3; ++i) o[i] = line.origin[i] - batch.centre[i];
  if (batch.even) {
    float square = 0.0f;
    for (int i = 0; i < 3; ++i) d[i] = all(line.direction[i]), square += line.direction[i] * line.direction[i];
    inverse = all(1.0f / square);
  } else {
    const Float8 from[3] = {o[0], o[1], o[2]};
    Float8 a = all(0.0f);
    for (int i = 0; i < 3; ++i) {
      const auto& row = batch.map[i];
      o[i] = fma(row[0], from[0], fma(row[1], from[1], row[2] * from[2]));
      d[i] = fma(row[0], all(line.direction[0]), fma(row[1], all(line.direction[1]), row[2] * line.direction[2]));
      a = fma(d[i], d[i], a);
    }
    const Mask8 along = a < 1e-20f;  // the axis, to within rounding
    for (Float8& x : d) x = along ? all(0.0f) : x;
    inverse = 1.0f / max(a, all(1e-20f));
  }
  for (int i = 0; i < 3; ++i) b = fma(o[i], d[i], b);
  const Float8 middle = -b * inverse;
  for (int i = 0; i < 3; ++i) {
    Float8 nearest = fma(middle, d[i], o[i]);
    distance2 = fma(nearest, nearest, distance2);
  }
  Float8 wide = batch.radius2[0] - distance2, narrow = batch.radius2[1] - distance2;
  if (!bits(wide >= 0.0f)) return false;
  Float8 wide_half = sqrt(max(wide, all(0.0f)) * inverse), narrow_half = sqrt(max(narrow, all(0.0f)) * inverse);
  const Float8 none = all(kNowhere);
  Mask8 outside = wide < 0.0f, grazing = (narrow <= 0.0f) | batch.rough;
  ends.in[0] = outside ? none : middle - wide_half;
  ends.out[0] = outside ? -none : middle + wide_half;
  ends.in[1] = grazing ? none : middle - narrow_half;
  ends.out[1] = grazing ? -none : middle + narrow_half;
  return true;
}

inline void cut_by_slab(const CsgFilter::Slab& slab, const FloatLine& line, Ends& ends) {
  const auto& n = slab.normal;
  Float8 at = fma(n[0], all(line.origin[0]), fma(n[1], all(line.origin[1]), n[2] * line.origin[2]));
  Float8 along = fma(n[0], all(line.direction[0]), fma(n[1], all(line.direction[1]), n[2] * line.direction[2]));
  Mask8 level = (along < 1e-20f) & (along > -1e-20f);
  Float8 per = 1.0f / (level ? all(1e-20f) : along);
  for (int k = 0; k < 2; ++k) {
    Float8 low = (slab.low[k] - at) * per, high = (slab.high[k] - at) * per;
    ends.in[k] = max(ends.in[k], min(low, high));
    ends.out[k] = min(ends.out[k], max(low, high));
  }
}

// False where the line meets none of the batch.
inline bool ends_of(const CsgFilter::Batch& batch, const FloatLine& line, Ends& ends) {
  if (batch.balls) {
    if (!meet_balls(batch, line, ends)) return false;
  } else {
    const Float8 none = all(kNowhere);
    ends.in[0] = -none;
    ends.out[0] = none;
    ends.in[1] = batch.rough ? none : -none;
    ends.out[1] = batch.rough ? -none : none;
  }
  for (int i = 0; i < batch.slab_count; ++i) cut_by_slab(batch.slabs[i], line, ends);
  return true;
}

}  // namespace tilecast
