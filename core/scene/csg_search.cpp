// The search among the bounds that scene/csg_ends.h gives.
#include "base/counters.h"
#include "geometry/sure_crossing.h"
#include "scene/csg_ends.h"
#include "scene/csg_search.h"

namespace tilecast {
namespace {

constexpr int kMostEvents = 64;

void fill(Crossing& out, uint64_t base, const Csg& csg, uint32_t operand, double t, int face, bool entering) {
  out = {};
  out.t = t;
  out.primitive = base + csg.assembly.first_primitive[operand] + face;
  out.entering = entering;
}

// Crossing number `number` of an operand that has two; false where it turns out not to.
bool solve_hit(const Scene& scene, const Csg& csg, const Ray& ray, uint64_t base, uint32_t operand, int number,
               bool entering, Crossing& out) {
  TILECAST_COUNT(solid);
  const Instance& instance = csg.assembly.instances[operand];
  SolidCrossing crossing;
  if (!sure_crossing(scene.solids[scene.objects[instance.object].index], instance.local(ray), number, crossing))
    return false;
  fill(out, base, csg, operand, crossing.t, crossing.face, entering);
  return true;
}

// Of a crossing around the ray's beginning: whether it lies behind for sure. Rays that leave a surface have one.
bool lies_behind(const Scene& scene, const Csg& csg, const Ray& ray, double t_min, uint32_t operand, int number) {
  if (t_min != 0.0) return false;
  const Instance& instance = csg.assembly.instances[operand];
  return sure_crossing_ahead(scene.solids[scene.objects[instance.object].index], instance.local(ray), number) == false;
}

// The search among at most eight operands, all of their states in the bits of one number. `Unsure` where an operand
// needs to be solved before the order is known.
Filtered search_few(const Scene& scene, const Csg& csg, const Ray& ray, double t_min, double t_max,
                    const FloatLine& line, float s_min, float s_max, uint64_t base, bool any, Crossing& out) {
  const CsgFilter::Batch& batch = csg.filter.batches[0];
  Ends ends;
  if (!ends_of(batch, line, ends)) return Filtered::Nothing;
  const Mask8 met = (ends.in[0] <= ends.out[0]) & (ends.out[0] >= s_min) & (ends.in[0] <= s_max);
  const uint32_t lanes = (1u << batch.count) - 1;
  if (bits(met & (ends.in[1] >= ends.out[1])) & lanes) return Filtered::Unsure;
  const Mask8 begun = met & (ends.in[1] < s_min);
  const Float8 never = all(kNowhere);
  // The bounds of what is to come.
  Float8 ins = (met & ~begun) ? ends.in[0] : never, outs = (met & (ends.out[1] <= s_max)) ? ends.out[1] : never;
  uint32_t within = bits(begun) & lanes;
  bool inside = csg.filter.inside[within];
  const float from = line.s(t_min), to = line.s(t_max);
  for (;;) {
    const float next = least(min(ins, outs));
    if (next == kNowhere) return Filtered::Nothing;
    const uint32_t entered = bits(ins == next);
    const bool enters = entered != 0;
    const int lane = std::countr_zero(enters ? entered : bits(outs == next));
    const float last = enters ? ends.in[1][lane] : ends.out[0][lane];
    const uint32_t in_too = bits(ins <= last), out_too = bits(outs <= last);
    if (std::popcount(in_too) + std::popcount(out_too) != 1) return Filtered::Unsure;
    const Mask8 gone = kLaneNumbers == lane;
    if (enters)
      ins = gone ? never : ins;
    else
      outs = gone ? never : outs;
    within ^= 1u << lane;
    if (csg.filter.inside[within] == inside) continue;
    inside = !inside;
    if (last < from) continue;
    if (next > to) return Filtered::Nothing;
    const bool at_end = next <= from || last >= to;
    if (any && !at_end) return Filtered::Found;
    if (next <= from && lies_behind(scene, csg, ray, t_min, batch.operand[lane], enters ? 0 : 1)) continue;
    if (!solve_hit(scene, csg, ray, base, batch.operand[lane], enters ? 0 : 1, inside, out)) return Filtered::Unsure;
    if (at_end) {
      if (!(out.t > t_min)) continue;
      if (out.t > t_max) return Filtered::Nothing;
      if (next < s_min || last > s_max) return Filtered::Unsure;  // what was left out may be together with it
    }
    return Filtered::Found;
  }
}

struct Event {
  double lo, hi;  // where its t is, with the error bound of the exact one
  double t;       // where it is exact
  uint32_t operand;
  int16_t face;
  uint8_t number;  // among the operand's
  bool entering, exact;
};

class Search {
 public:
  Search(const Scene& scene, const Csg& csg, const Ray& ray, double t_min, double t_max)
      : scene_(scene), csg_(csg), ray_(ray), t_min_(t_min), t_max_(t_max) {
    for (size_t i = 0; i < csg.nodes.size(); ++i) inside_[i] = 0, first_inside_[i] = 0;
  }

  Filtered run(const FloatLine& line, float s_min, float s_max, uint64_t base, bool any, Crossing& out);

 private:
  bool gather(const FloatLine& line, float s_min, float s_max);
  bool add(const Event& event);
  bool refine(uint32_t operand);
  CsgState state() { return {inside_, first_inside_}; }

  const Scene& scene_;
  const Csg& csg_;
  const Ray& ray_;
  double t_min_, t_max_, low_, high_;
  uint32_t inside_[kMostFilterNodes];
  uint8_t first_inside_[kMostFilterNodes];
  Event events_[kMostEvents];
  int count_ = 0;
};

// False where there is no room for it.
bool Search::add(const Event& event) {
  if (event.lo > high_) return true;
  if (event.hi < low_) {
    state().enter(csg_, event.operand, event.entering);
    return true;
  }
  if (count_ == kMostEvents) return false;
  events_[count_++] = event;
  return true;
}

// Puts the exact crossings of an operand in the place of their bounds; false where they do not fit.
bool Search::refine(uint32_t operand) {
  SolidCrossing list[kMaxSolidCrossings];
  if (operand_crossings(scene_, csg_, operand, ray_, list) != 2) return false;
  for (int i = 0; i < count_; ++i) {
    Event& event = events_[i];
    if (event.operand != operand) continue;
    const SolidCrossing& crossing = list[event.number];
    event = {crossing.t - crossing.error, crossing.t + crossing.error, crossing.t, operand,
             static_cast<int16_t>(crossing.face), event.number, crossing.entering, true};
  }
  return true;
}

// The events of all operands; false where there are too many.
bool Search::gather(const FloatLine& line, float s_min, float s_max) {
  const CsgFilter& filter = csg_.filter;
  auto look_at = [&](const CsgFilter::Batch& batch) {
    Ends ends;
    if (!ends_of(batch, line, ends)) return true;
    uint32_t met = bits((ends.in[0] <= ends.out[0]) & (ends.out[0] >= s_min) & (ends.in[0] <= s_max)) &
                   ((1u << batch.count) - 1);
    const uint32_t sure = bits(ends.in[1] < ends.out[1]);
    for (; met != 0; met &= met - 1) {
      const int lane = std::countr_zero(met);
      const uint32_t operand = batch.operand[lane];
      if (sure >> lane & 1) {
        if (!add({line.t(ends.in[0][lane]), line.t(ends.in[1][lane]), 0.0, operand, 0, 0, true, false}) ||
            !add({line.t(ends.out[1][lane]), line.t(ends.out[0][lane]), 0.0, operand, 0, 1, false, false}))
          return false;
        continue;
      }
      SolidCrossing list[kMaxSolidCrossings];
      const int found = operand_crossings(scene_, csg_, operand, ray_, list);
      for (int i = 0; i < found; ++i)
        if (!add({list[i].t - list[i].error, list[i].t + list[i].error, list[i].t, operand,
                  static_cast<int16_t>(list[i].face), static_cast<uint8_t>(i), list[i].entering, true}))
          return false;
    }
    return true;
  };
  if (!filter.boxes.empty()) return filter.each_met(line, s_min, s_max, look_at);
  for (const CsgFilter::Batch& batch : filter.batches)
    if (!look_at(batch)) return false;
  return true;
}

Filtered Search::run(const FloatLine& line, float s_min, float s_max, uint64_t base, bool any, Crossing& out) {
  low_ = line.t(s_min);
  high_ = line.t(s_max);
  if (!gather(line, s_min, s_max)) return Filtered::Unsure;
  bool inside = state().at(csg_.nodes[0], 0);
  while (count_ > 0) {
    int first = 0;
    for (int i = 1; i < count_; ++i)
      if (events_[i].lo < events_[first].lo) first = i;
    int second = -1;
    for (int i = 0; i < count_; ++i)
      if (i != first && events_[i].lo <= events_[first].hi && (second < 0 || !events_[i].exact)) second = i;
    const Event event = events_[first];
    if (second >= 0) {  // in which order?
      if (!event.exact) {
        if (!refine(event.operand)) return Filtered::Unsure;
      } else if (!events_[second].exact) {
        if (!refine(events_[second].operand)) return Filtered::Unsure;
      } else {
        return Filtered::Unsure;
      }
      continue;
    }
    state().enter(csg_, event.operand, event.entering);
    const bool now_inside = state().at(csg_.nodes[0], 0);
    events_[first] = events_[--count_];
    if (now_inside == inside) continue;
    inside = now_inside;
    if (event.hi < t_min_) continue;
    if (event.lo > t_max_) return Filtered::Nothing;
    const bool at_end = event.lo <= t_min_ || event.hi >= t_max_;
    if (any && !at_end) return Filtered::Found;
    if (!event.exact && event.lo <= t_min_ && lies_behind(scene_, csg_, ray_, t_min_, event.operand, event.number))
      continue;
    if (event.exact)
      fill(out, base, csg_, event.operand, event.t, event.face, now_inside);
    else if (!solve_hit(scene_, csg_, ray_, base, event.operand, event.number, now_inside, out))
      return Filtered::Unsure;
    if (at_end) {
      if (!(out.t > t_min_)) continue;
      if (out.t > t_max_) return Filtered::Nothing;
      if (event.lo < low_ || event.hi > high_) return Filtered::Unsure;
    }
    return Filtered::Found;
  }
  return Filtered::Nothing;
}

}  // namespace

Filtered first_crossing(const Scene& scene, const Csg& csg, const Ray& ray, double t_min, double t_max, uint64_t base,
                        bool any, Crossing& out) {
  TILECAST_COUNT(csg);
  FloatLine line;
  if (!enter_line(csg.assembly.frame, ray, line)) return Filtered::Nothing;
  if (!(line.farthest <= kFarthest)) return Filtered::Unsure;
  float s_min = line.s(t_min) - static_cast<float>(kRoom), s_max = line.s(t_max) + static_cast<float>(kRoom);
  clip_to_box(csg.filter.result_box, line, s_min, s_max);
  if (!(s_min <= s_max)) return Filtered::Nothing;
  if (csg.filter.batches.size() == 1) {
    Filtered found = search_few(scene, csg, ray, t_min, t_max, line, s_min, s_max, base, any, out);
    if (found != Filtered::Unsure) return found;
  }
  // Among many operands stretch by stretch, each longer than the one before: the first crossing is known before what lies
  // behind is looked at.
  float length = csg.filter.stride;
  for (;;) {
    const float s_end = s_min + length;
    const bool last = !(s_end < s_max && line.t(s_end) < t_max);
    const double t_end = last ? t_max : line.t(s_end);
    const Filtered found = Search(scene, csg, ray, t_min, t_end)
                               .run(line, s_min, last ? s_max : s_end + static_cast<float>(kRoom), base, any, out);
    if (found != Filtered::Nothing || last) return found;
    t_min = t_end;
    s_min = s_end - static_cast<float>(kRoom);
    length *= 4.0f;
  }
}

}  // namespace tilecast
