// Constructive solid geometry on the intervals of a line.
//
// Roth, "Ray Casting for Modeling Solids", CGIP 18(2), 1982, without the merging of interval lists: walking along the
// line through the crossings of all operands keeps a counter in every node of the tree. A crossing of the result is
// where the root's state changes. The tree is walked upwards from the operand only as far as a state changes, without
// recursion, so depth costs no stack.
//
// The operands are entered in the order of their boxes along the line, and the walk stays behind the next box: the
// first crossing is known before what lies behind it was looked at. What lies outside of the result's own bounds or of
// the ray's range is not looked at at all; closed operands that end before the range leave their counters at zero.
//
// Crossings whose distance is within the sum of their error bounds are one event: states are compared before and after
// all of them. So coincident faces leave no sliver: a union loses the wall between its parts, a difference with a flush
// face loses that face. Where several operands could give the surface, the first in the order of the scene does.
#pragma once

#include "scene/trace.h"

namespace tilecast {

class CsgWalk {
 public:
  CsgWalk(const Scene& scene, const Csg& csg, const Ray& line, double t_min, double t_max, uint64_t base)
      : scene_(scene), csg_(csg), line_(line), t_min_(t_min), t_max_(t_max), base_(base) {}

  // Calls visit(crossing) in order, entries and exits in turn, until it returns true.
  template <class Visit>
  void run(Visit&& visit) {
    FrameRay local;
    float s_min, s_max;
    if (!begin(local, s_min, s_max)) return;
    const auto& order = csg_.assembly.accelerator.order();
    bool ended = false;
    csg_.tree().traverse_in_order(local, s_min, s_max, open(), [&](uint32_t first, uint32_t count, float s) {
      if (advance(local, s, visit)) return ended = true;
      for (uint32_t i = first; i < first + count; ++i) gather(order[i]);
      return false;
    });
    if (!ended) advance(local, std::numeric_limits<float>::infinity(), visit);
    end();
  }

 private:
  bool begin(FrameRay& local, float& s_min, float& s_max);
  void gather(uint32_t operand);
  // The next event that lies safely before t_open; false where there is none. `surface` is set where the root changes.
  bool next_event(double t_open, Crossing& surface, bool& changed);
  void end();
  std::vector<Bvh::Pending>& open();

  template <class Visit>
  bool advance(const FrameRay& local, float s, Visit&& visit) {
    double t_open = s == kMissed ? kInfinity : local.t_below(s);
    Crossing surface;
    bool changed;
    while (next_event(t_open, surface, changed))
      if (changed && visit(surface)) return true;
    return false;
  }

  const Scene& scene_;
  const Csg& csg_;
  const Ray& line_;
  double t_min_, t_max_;
  uint64_t base_;
};

// Visits the crossings of the result, in order, until visit(crossing) returns true. Those in t_min < t <= t_max are
// all there, and none is wrong; others may be missing.
template <class Visit>
void visit_crossings(const Scene& scene, const Csg& csg, const Ray& line, double t_min, double t_max, uint64_t base,
                     Visit&& visit) {
  CsgWalk(scene, csg, line, t_min, t_max, base).run(visit);
}

}  // namespace tilecast
