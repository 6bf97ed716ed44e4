#include "integrators/plain_hits.h"

#include "geometry/ball_lanes.h"

namespace tilecast {
namespace {

using Shape = PlainScene::Shape;

// A coordinate in the object's space, of a vector of world space.
Double4 local(const Shape& shape, int i, const Vec3x4& v) {
  return fma(shape.to_local[i][0], v.x, fma(shape.to_local[i][1], v.y, shape.to_local[i][2] * v.z));
}

// Where a line is inside of something convex.
struct Chord {
  Double4 enter, exit;
  Mask4 met;
};
struct BoxChord : Chord {
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

// inside_ball() of geometry/ball.h; met where it is asked for.
[[gnu::always_inline]] inline Chord in_ball(const Shape& ball, const Vec3x4& from, const Vec3x4& direction, Mask4 asked) {
  Double4 origin[3], along[3];
  for (int i = 0; i < 3; ++i) origin[i] = local(ball, i, from), along[i] = local(ball, i, direction);
  const NearOneLanes<Double4, 3> near(origin, along, ball.radius);
  const Vec3x4 o{near.o[0], near.o[1], near.o[2]}, d{near.d[0], near.d[1], near.d[2]};
  const Vec3x4 nearest = o - dot(o, d) / dot(d, d) * d;
  const Double4 room = near.radius + 0x1p-48 * max_abs(o);
  Chord out{{}, {}, asked & ~(dot(nearest, nearest) > room * room) & ~near.still};
  if (!bits(out.met)) return out;
  const BallRoots<Double4> roots(near);
  out.met &= roots.meets;
  const Double4 first = roots.q / (roots.a.value() + 0.0), second = roots.c.value() / roots.q;
  out.enter = min(first, second) * near.unit, out.exit = max(first, second) * near.unit;
  out.met &= (out.enter < out.exit) & (abs(out.enter) < kInfinity) & (abs(out.exit) < kInfinity);
  return out;
}

// Block's.
template <bool kFaces>
[[gnu::always_inline]] inline BoxChord in_box(const Shape& box, const BoxLine& line) {
  BoxChord out{{all(-kInfinity), all(kInfinity), all(true)}, {}, {}};
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

// Whether what is met at t stands before the light.
Mask4 shadows(Double4 t) { return (t > 0.0) & (t <= 1.0); }

}  // namespace

template <bool kChalk>
PlainHits closest(const PlainScene& plain, const Vec3x4& origin, const Vec3x4& direction) {
  PlainHits best;
  for (const Shape& shape : plain.shapes) {
    const Vec3x4 from{origin.x - shape.origin[0], origin.y - shape.origin[1], origin.z - shape.origin[2]};
    if (!kChalk && shape.kind == Shape::Kind::Ball) {
      const Chord chord = in_ball(shape, from, direction, all(true));
      const Mask4 outside = chord.enter > 0.0;
      const Double4 t = outside ? chord.enter : chord.exit;
      const Mask4 nearer = chord.met & (t > 0.0) & (t < best.t);
      best.t = nearer ? t : best.t;
      best.face = nearer ? shape.face + Mask4{} : best.face;
      best.entering = nearer ? outside : best.entering;
      continue;
    }
    if (shape.kind == Shape::Kind::Box) {
      const BoxChord chord = in_box<true>(shape, BoxLine(shape, from, direction));
      const Mask4 outside = chord.enter > 0.0;
      const Double4 t = outside ? chord.enter : chord.exit;
      const Mask4 nearer = chord.met & (t > 0.0) & (t < best.t);
      best.t = nearer ? t : best.t;
      best.face = nearer ? shape.face + (outside ? chord.enter_face : chord.exit_face) : best.face;
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

template <bool kChalk>
Mask4 occluded(const PlainScene& plain, const Vec3x4& origin, const Vec3x4& direction, Mask4 asked) {
  Mask4 stopped{};
  for (const Shape& shape : plain.shapes) {
    const Vec3x4 from{origin.x - shape.origin[0], origin.y - shape.origin[1], origin.z - shape.origin[2]};
    if (!kChalk && shape.kind == Shape::Kind::Ball) {
      const Chord chord = in_ball(shape, from, direction, asked & ~stopped);
      stopped |= chord.met & (shadows(chord.enter) | shadows(chord.exit));
    } else if (shape.kind == Shape::Kind::Box) {
      const BoxLine line(shape, from, direction);
      if (!bits(asked & ~stopped & ~line.beside(shape))) continue;
      const BoxChord chord = in_box<false>(shape, line);
      stopped |= chord.met & (shadows(chord.enter) | shadows(chord.exit));
    } else {
      // Most are not crossed: then signs or sizes tell before anything is divided, as t <= 1 means |above| <= |down|.
      const Double4 above = local(shape, 1, from), down = local(shape, 1, direction);
      Mask4 within = ((Mask4)above ^ (Mask4)down) & ((abs(above) <= abs(down)) & asked & ~stopped);
      if (!bits(within)) continue;
      const Double4 t = -above / down;
      within = shadows(t) & asked & ~stopped;
      const Double4 x = fma(t, local(shape, 0, direction), local(shape, 0, from));
      const Double4 z = fma(t, local(shape, 2, direction), local(shape, 2, from));
      stopped |= within & (shape.lo[0] <= x) & (x < shape.hi[0]) & (shape.lo[2] <= z) & (z < shape.hi[2]);
    }
    if (!bits(asked & ~stopped)) break;
  }
  return stopped;
}

template PlainHits closest<true>(const PlainScene&, const Vec3x4&, const Vec3x4&);
template PlainHits closest<false>(const PlainScene&, const Vec3x4&, const Vec3x4&);
template Mask4 occluded<true>(const PlainScene&, const Vec3x4&, const Vec3x4&, Mask4);
template Mask4 occluded<false>(const PlainScene&, const Vec3x4&, const Vec3x4&, Mask4);

}  // namespace tilecast
