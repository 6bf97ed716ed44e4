#include "scene/csg_lanes.h"

#include "base/counters.h"
#include "geometry/sure_crossing.h"
#include "scene/csg_ends.h"

namespace tilecast {
namespace {

using Single = CsgFilter::Single;

// Where each line enters and leaves the ball: meet_balls of scene/csg_ends.h, by lines.
void meet_ball(const Single& single, const FloatLines& lines, Ends& ends) {
  const Float8(&direction)[3] = lines.directions->direction;
  Float8 o[3], d[3], inverse;
  const int rows = single.rows;
  if (single.ball == Single::Ball::Even) {
    Float8 a = all(0.0f);
    for (int i = 0; i < rows; ++i) {
      const int axis = single.axes[i];
      o[i] = lines.origin[axis] - single.centre[axis], d[i] = direction[axis];
      if (rows < 3) a = fma(d[i], d[i], a);
    }
    if (rows == 3) {
      inverse = lines.directions->inverse_square;
    } else {
      const Mask8 along = a < 1e-20f;  // the axis, to within rounding
      for (int i = 0; i < rows; ++i) d[i] = along ? all(0.0f) : d[i];
      inverse = 1.0f / max(a, all(1e-20f));
    }
  } else {
    Float8 from[3], a = all(0.0f);
    for (int i = 0; i < 3; ++i) from[i] = lines.origin[i] - single.centre[i];
    for (int i = 0; i < rows; ++i) {
      const float* row = single.map[i];
      o[i] = fma(all(row[0]), from[0], fma(all(row[1]), from[1], row[2] * from[2]));
      d[i] = fma(all(row[0]), direction[0], fma(all(row[1]), direction[1], row[2] * direction[2]));
      a = fma(d[i], d[i], a);
    }
    const Mask8 along = a < 1e-20f;  // the axis, to within rounding
    for (int i = 0; i < rows; ++i) d[i] = along ? all(0.0f) : d[i];
    inverse = 1.0f / max(a, all(1e-20f));
  }
  Float8 b = all(0.0f), distance2 = all(0.0f);
  for (int i = 0; i < rows; ++i) b = fma(o[i], d[i], b);
  const Float8 middle = -b * inverse;
  for (int i = 0; i < rows; ++i) {
    const Float8 nearest = fma(middle, d[i], o[i]);
    distance2 = fma(nearest, nearest, distance2);
  }
  const Float8 wide = single.radius2[0] - distance2, narrow = single.radius2[1] - distance2, none = all(kNowhere);
  const Float8 wide_half = sqrt(max(wide, all(0.0f)) * inverse), narrow_half = sqrt(max(narrow, all(0.0f)) * inverse);
  const Mask8 outside = wide < 0.0f, grazing = narrow <= 0.0f;
  ends.in[0] = outside ? none : middle - wide_half;
  ends.out[0] = outside ? -none : middle + wide_half;
  ends.in[1] = grazing ? none : middle - narrow_half;
  ends.out[1] = grazing ? -none : middle + narrow_half;
}

void cut_by_slab(const Single::Slab& slab, const FloatLines& lines, Ends& ends) {
  const Float8(&direction)[3] = lines.directions->direction;
  Float8 at, per;
  if (slab.along >= 0) {
    at = lines.origin[slab.along], per = lines.directions->reciprocal[slab.along];
  } else {
    const float* n = slab.normal;
    at = fma(all(n[0]), lines.origin[0], fma(all(n[1]), lines.origin[1], n[2] * lines.origin[2]));
    const Float8 along = fma(all(n[0]), direction[0], fma(all(n[1]), direction[1], n[2] * direction[2]));
    const Mask8 level = (along < 1e-20f) & (along > -1e-20f);
    per = 1.0f / (level ? all(1e-20f) : along);
  }
  for (int k = 0; k < 2; ++k) {
    const Float8 low = (slab.low[k] - at) * per, high = (slab.high[k] - at) * per;
    ends.in[k] = max(ends.in[k], min(low, high));
    ends.out[k] = min(ends.out[k], max(low, high));
  }
}

void ends_of(const Single& single, const FloatLines& lines, Ends& ends) {
  if (single.ball != Single::Ball::None) {
    meet_ball(single, lines, ends);
  } else {
    const Float8 none = all(kNowhere);
    ends.in[0] = ends.in[1] = -none;
    ends.out[0] = ends.out[1] = none;
  }
  for (int i = 0; i < single.slab_count; ++i) cut_by_slab(single.slabs[i], lines, ends);
  if (single.rough) ends.in[1] = all(kNowhere), ends.out[1] = all(-kNowhere);
}

// Whether a point is inside the result, by the operands that it is inside of.
Mask8 inside_at(const CsgFilter& filter, Mask8 within) {
#ifdef __AVX2__
  const Mask8 word = (Mask8)_mm256_permutevar8x32_epi32((__m256i)filter.inside_bits, (__m256i)(within >> 5));
#else
  Mask8 word;
  for (int i = 0; i < kLanes; ++i) word[i] = filter.inside_bits[within[i] >> 5];
#endif
  return -((word >> (within & 31)) & 1);
}

// Calls each(what, lanes) for lanes of which the same is asked, one value of `which` after the other.
template <class Each>
void by_kind(uint32_t lanes, Mask8 which, Each&& each) {
  while (lanes != 0) {
    const int32_t what = which[std::countr_zero(lanes)];
    const uint32_t alike = bits(which == what) & lanes;
    lanes &= ~alike;
    each(what, alike);
  }
}

// A search through the crossings of eight lines at once. Events are numbered: twice the operand's place among the
// filter's, and 1 more where it is left.
class LaneSearch {
 public:
  LaneSearch(const Scene& scene, const Csg& csg, const RayLanes& rays, const Double8& t_min, const Double8& t_max)
      : scene_(scene), csg_(csg), rays_(rays), t_min_(t_min), t_max_(t_max) {}

  template <bool kAny>
  void run(uint32_t lanes, CrossingLanes& out);

 private:
  void gather(const FloatLines& lines, Float8 s_min, Float8 s_max, uint32_t lanes);
  uint32_t behind(uint32_t lanes, Mask8 which) const;
  uint32_t solve(uint32_t lanes, Mask8 which, CrossingLanes& out) const;
  const Single& single(int32_t event) const { return csg_.filter.singles[event >> 1]; }
  const Solid& solid(const Instance& instance) const { return scene_.solids[scene_.objects[instance.object].index]; }

  const Scene& scene_;
  const Csg& csg_;
  const RayLanes& rays_;
  const Double8 &t_min_, &t_max_;
  struct Events {  // of each line one
    Float8 first, last;  // bounds
    Mask8 number;
  };
  void put_in_order();

  Events events_[2 * kLanes + 1];  // and one that is never
  int count_ = 0;
  Mask8 within_ = {};
  uint32_t doubtful_ = 0;
};

void LaneSearch::gather(const FloatLines& lines, Float8 s_min, Float8 s_max, uint32_t lanes) {
  const Float8 never = all(kNowhere);
  for (size_t k = 0; k < csg_.filter.singles.size(); ++k) {
    Ends ends;
    ends_of(csg_.filter.singles[k], lines, ends);
    const Mask8 met = (ends.in[0] <= ends.out[0]) & (ends.out[0] >= s_min) & (ends.in[0] <= s_max);
    if (!(bits(met) & lanes)) continue;
    doubtful_ |= bits(met & (ends.in[1] >= ends.out[1]));
    const Mask8 begun = met & (ends.in[1] < s_min), enters = met & ~begun, leaves = met & (ends.out[1] <= s_max);
    within_ |= begun & (1 << k);
    if (bits(enters) & lanes) {
      events_[count_++] = {enters ? ends.in[0] : never, ends.in[1], Mask8{} + static_cast<int32_t>(2 * k)};
    }
    if (bits(leaves) & lanes) {
      events_[count_++] = {leaves ? ends.out[1] : never, ends.out[0], Mask8{} + static_cast<int32_t>(2 * k + 1)};
    }
  }
}

// By their first bounds: Batcher's merge exchange (Knuth, "The Art of Computer Programming" 3, 5.2.2, algorithm M).
void LaneSearch::put_in_order() {
  if (count_ < 2) return;
  const int largest = static_cast<int>(std::bit_floor(static_cast<unsigned>(count_ - 1)));
  for (int p = largest; p > 0; p >>= 1)
    for (int q = largest, r = 0, d = p; ; d = q - p, q >>= 1, r = p) {
      for (int i = 0; i < count_ - d; ++i) {
        if ((i & p) != r) continue;
        Events &a = events_[i], &b = events_[i + d];
        const Mask8 swap = a.first > b.first;
        const Float8 first = min(a.first, b.first), last = swap ? b.last : a.last;
        const Mask8 number = swap ? b.number : a.number;
        b = {max(a.first, b.first), swap ? a.last : b.last, swap ? a.number : b.number};
        a = {first, last, number};
      }
      if (q == p) break;
    }
}

// Of crossings around the rays' beginnings, t = 0: those that lie behind for sure.
uint32_t LaneSearch::behind(uint32_t lanes, Mask8 which) const {
  uint32_t out = 0;
  by_kind(lanes, which, [&](int32_t event, uint32_t alike) {
    const Single& one = single(event);
    const Instance& instance = csg_.assembly.instances[one.operand];
    if (one.solved_in_lanes && std::popcount(alike) > 1) {
      LineLanes local;
      bring(instance, rays_.line, local);
      out |= sure_crossings_ahead(solid(instance), local, event & 1).no & alike;
      return;
    }
    for (; alike != 0; alike &= alike - 1) {
      const int lane = std::countr_zero(alike);
      if (sure_crossing_ahead(solid(instance), instance.local(rays_.line.line(lane)), event & 1) == false) out |= 1u << lane;
    }
  });
  return out;
}

// One bit a lane that has the crossing.
uint32_t LaneSearch::solve(uint32_t lanes, Mask8 which, CrossingLanes& out) const {
  uint32_t solved = 0;
  by_kind(lanes, which, [&](int32_t event, uint32_t alike) {
    TILECAST_COUNT(solid);
    const Single& one = single(event);
    const Instance& instance = csg_.assembly.instances[one.operand];
    if (one.solved_in_lanes && std::popcount(alike) > 1) {
      LineLanes local;
      bring(instance, rays_.line, local);
      Double8 t;
      int32_t face[kLanes];
      alike &= sure_crossings(solid(instance), local, event & 1, t, face);
      solved |= alike;
      for (; alike != 0; alike &= alike - 1) {
        const int lane = std::countr_zero(alike);
        out.t.set(lane, t[lane]);
        out.face[lane] = face[lane], out.operand[lane] = static_cast<int32_t>(one.operand);
      }
      return;
    }
    for (; alike != 0; alike &= alike - 1) {
      const int lane = std::countr_zero(alike);
      SolidCrossing crossing;
      if (!sure_crossing(solid(instance), instance.local(rays_.line.line(lane)), event & 1, crossing)) continue;
      solved |= 1u << lane;
      out.t.set(lane, crossing.t);
      out.face[lane] = crossing.face, out.operand[lane] = static_cast<int32_t>(one.operand);
    }
  });
  return solved;
}

template <bool kAny>
void LaneSearch::run(uint32_t lanes, CrossingLanes& out) {
  FloatLines lines;
  lanes &= lines.enter(csg_.assembly.frame, rays_);
  const uint32_t far = lanes & ~bits(lines.farthest <= kFarthest);
  out.unsure = far;
  lanes &= ~far;
  if (lanes == 0) return;
  const Float8 from = lines.s(t_min_), to = lines.s(t_max_), room = all(static_cast<float>(kRoom)), never = all(kNowhere);
  Float8 s_min = from - room, s_max = to + room;
  const FrameBox& box = csg_.filter.result_box;
  uint32_t open = lanes & bits(clip_to_box(box.lo, box.hi, lines, s_min, s_max));
  if (open == 0) return;
  gather(lines, s_min, s_max, open);
  out.unsure |= doubtful_ & open;
  open &= ~doubtful_;
  Mask8 within = within_, inside = inside_at(csg_.filter, within);
  uint32_t to_solve = 0;
  Mask8 picked = {};
  put_in_order();
  events_[count_].first = never;
  for (int e = 0; open != 0; ++e) {
    const Float8 next = events_[e].first, last = events_[e].last;
    const Mask8 which = events_[e].number;
    open &= ~bits(next == never);
    if (open == 0) break;
    within ^= (Mask8{} + 1) << (which >> 1);
    const uint32_t together = bits(events_[e + 1].first <= last) & open;
    out.unsure |= together;
    open &= ~together;
    const Mask8 now = inside_at(csg_.filter, within), changed = now ^ inside;
    inside = now;
    uint32_t at = bits(changed & ~(last < from)) & open;
    if (at == 0) continue;
    const uint32_t past = bits(next > to) & at;
    open &= ~past, at &= ~past;
    const uint32_t begins = bits(next <= from) & at, at_end = begins | (bits(last >= to) & at);
    if (kAny) {
      out.found |= at & ~at_end;
      open &= ~(at & ~at_end);
      at = at_end;
    }
    if (at_end != 0) {
      uint32_t left = at_end;
      const uint32_t from_zero = begins & bits(t_min_ == 0.0);
      if (from_zero != 0) left &= ~behind(from_zero, which);
      const uint32_t entering = bits(inside);
      if (left != 0) {
        const uint32_t solved = solve(left, which, out), after = bits(out.t > t_min_) & solved;
        const uint32_t beyond = after & bits(out.t > t_max_), cut = after & bits((next < s_min) | (last > s_max)) & ~beyond;
        const uint32_t good = after & ~beyond & ~cut;
        out.unsure |= (left & ~solved) | cut;
        out.found |= good;
        out.entering |= good & entering;
        open &= ~((left & ~solved) | after);
      }
    }
    const uint32_t within_range = at & ~at_end;
    if (within_range != 0) {
      picked = lanes_of(within_range) ? which : picked;
      out.entering |= within_range & bits(inside);
      to_solve |= within_range;
      open &= ~within_range;
    }
  }
  if (to_solve != 0) {
    const uint32_t solved = solve(to_solve, picked, out);
    out.found |= solved;
    out.unsure |= to_solve & ~solved;
  }
}

}  // namespace

template <bool kAny>
void first_crossings(const Scene& scene, const Csg& csg, const RayLanes& rays, uint32_t lanes, const Double8& t_min,
                     const Double8& t_max, CrossingLanes& out) {
  TILECAST_COUNT(csg);
  LaneSearch(scene, csg, rays, t_min, t_max).run<kAny>(lanes, out);
}

template void first_crossings<false>(const Scene&, const Csg&, const RayLanes&, uint32_t, const Double8&, const Double8&,
                                     CrossingLanes&);
template void first_crossings<true>(const Scene&, const Csg&, const RayLanes&, uint32_t, const Double8&, const Double8&,
                                    CrossingLanes&);

}  // namespace tilecast
