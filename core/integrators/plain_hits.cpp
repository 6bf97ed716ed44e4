#include "integrators/plain_hits.h"

namespace tilecast {
namespace {

using Shape = PlainScene::Shape;

// A coordinate in the object's space, of a vector of world space.
Double4 local(const Shape& shape, int i, const Vec3x4& v) {
  return fma(shape.to_local[i][0], v.x, fma(shape.to_local[i][1], v.y, shape.to_local[i][2] * v.z));
}

// Where a line is inside a box: Block's.
struct BoxInterval {
  Double4 enter, exit;
  Mask4 met;
  Mask4 enter_face, exit_face;
};

struct BoxLine {  // in the box's space
  Double4 o[3], d[3];

  BoxLine(const Shape& box, const Vec3x4& from, const Vec3x4& direction) {
    for (int i = 0; i < 3; ++i) o[i] = local(box, i, from), d[i] = local(box, i, direction);
  }

  // Whether 0 < t <= 1 lies on the outer side of one face, which costs no division: (hi - o) / d > 1 just where the
  // numerator is the larger one.
  Mask4 beside(const Shape& box) const {
    Mask4 out{};
    for (int i = 0; i < 3; ++i) {
      const Double4 below = box.lo[i] - o[i], above = box.hi[i] - o[i];
      out |= ((below > 0.0) & (below > d[i])) | ((above < 0.0) & (above < d[i]));
    }
    return out;
  }
};

template <bool kFaces>
BoxInterval inside(const Shape& box, const BoxLine& line) {
  BoxInterval out{all(-kInfinity), all(kInfinity), all(true), {}, {}};
  for (int i = 0; i < 3; ++i) {
    const Double4 o = line.o[i], d = line.d[i];
    const Double4 low = (box.lo[i] - o) / d, high = (box.hi[i] - o) / d;
    const Mask4 up = d > 0.0, flat = d == 0.0;
    Double4 enter = up ? low : high, exit = up ? high : low;
    if (bits(flat)) [[unlikely]] {
      out.met &= ~flat | ((box.lo[i] <= o) & (o < box.hi[i]));
      enter = flat ? all(-kInfinity) : enter;
      exit = flat ? all(kInfinity) : exit;
    }
    out.met &= enter < exit;
    const Mask4 later = enter > out.enter, sooner = exit < out.exit;
    out.enter = later ? enter : out.enter;
    out.exit = sooner ? exit : out.exit;
    if constexpr (kFaces) {  // up: in by the lower face, out by the upper one; up is -1
      out.enter_face = later ? 2 * i + 1 + up : out.enter_face;
      out.exit_face = sooner ? 2 * i - up : out.exit_face;
    }
  }
  out.met &= (out.enter < out.exit) & (out.enter > -kInfinity) & (out.exit < kInfinity);
  return out;
}

}  // namespace

PlainHits closest(const PlainScene& plain, const Vec3x4& origin, const Vec3x4& direction) {
  PlainHits best;
  for (const Shape& shape : plain.shapes) {
    const Vec3x4 from{origin.x - shape.origin[0], origin.y - shape.origin[1], origin.z - shape.origin[2]};
    if (shape.box) {
      const BoxInterval interval = inside<true>(shape, BoxLine(shape, from, direction));
      const Mask4 outside = interval.enter > 0.0;
      const Double4 t = outside ? interval.enter : interval.exit;
      const Mask4 nearer = interval.met & (t > 0.0) & (t < best.t);
      best.t = nearer ? t : best.t;
      best.face = nearer ? shape.face + (outside ? interval.enter_face : interval.exit_face) : best.face;
      best.entering = nearer ? outside : best.entering;
      continue;
    }
    const Double4 down = local(shape, 1, direction), t = -local(shape, 1, from) / down;
    Mask4 nearer = (t > 0.0) & (t < best.t);
    if (!bits(nearer)) continue;
    const Double4 x = fma(t, local(shape, 0, direction), local(shape, 0, from));
    const Double4 z = fma(t, local(shape, 2, direction), local(shape, 2, from));
    nearer &= (shape.lo[0] <= x) & (x < shape.hi[0]) & (shape.lo[2] <= z) & (z < shape.hi[2]);
    best.t = nearer ? t : best.t;
    best.face = nearer ? shape.face + Mask4{} : best.face;
    best.entering = nearer ? down < 0.0 : best.entering;
  }
  return best;
}

Mask4 occluded(const PlainScene& plain, const Vec3x4& origin, const Vec3x4& direction, Mask4 asked) {
  Mask4 stopped{};
  for (const Shape& shape : plain.shapes) {
    const Vec3x4 from{origin.x - shape.origin[0], origin.y - shape.origin[1], origin.z - shape.origin[2]};
    if (shape.box) {
      const BoxLine line(shape, from, direction);
      if (!bits(asked & ~stopped & ~line.beside(shape))) continue;
      const BoxInterval interval = inside<false>(shape, line);
      auto within = [](Double4 t) { return (t > 0.0) & (t <= 1.0); };
      stopped |= interval.met & (within(interval.enter) | within(interval.exit));
    } else {
      // Most are not crossed: then signs or sizes tell before anything is divided, as t <= 1 means |above| <= |down|.
      const Double4 above = local(shape, 1, from), down = local(shape, 1, direction);
      Mask4 within = ((Mask4)above ^ (Mask4)down) & ((abs(above) <= abs(down)) & asked & ~stopped);
      if (!bits(within)) continue;
      const Double4 t = -above / down;
      within = (t > 0.0) & (t <= 1.0) & asked & ~stopped;
      const Double4 x = fma(t, local(shape, 0, direction), local(shape, 0, from));
      const Double4 z = fma(t, local(shape, 2, direction), local(shape, 2, from));
      stopped |= within & (shape.lo[0] <= x) & (x < shape.hi[0]) & (shape.lo[2] <= z) & (z < shape.hi[2]);
    }
    if (!bits(asked & ~stopped)) break;
  }
  return stopped;
}

}  // namespace tilecast
