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
// This walk takes all that scene/csg_filter.h leaves open, and whole lines.
//
// Crossings that may be at one place, by their error bounds, are one event: states are compared before and after all of
// them. So coincident faces leave no sliver: a union loses the wall between its parts, a difference with a flush face
// loses that face. Where several operands could give the surface, the first in the order of the scene does.
#pragma once

#include "scene/trace.h"

namespace tilecast {

// The states of a tree's nodes, all of them outside at first.
struct CsgState {
  uint32_t* inside;       // node: children inside; of a difference, subtracted children inside
  uint8_t* first_inside;  // node: the first child is inside

  bool at(const Csg::Node& node, int index) const {
    switch (node.operation) {
      case CsgOperation::Union: return inside[index] > 0;
      case CsgOperation::Intersection: return inside[index] == node.children;
      default: return first_inside[index] && inside[index] == 0;
    }
  }

  // Into an operand, or out of it: upwards as far as a state changes.
  void enter(const Csg& csg, uint32_t operand, bool now_inside) {
    bool first = csg.operands[operand].first;
    for (int index = csg.operands[operand].parent; index >= 0;) {
      const Csg::Node& node = csg.nodes[index];
      bool before = at(node, index);
      if (node.operation == CsgOperation::Difference && first)
        first_inside[index] = now_inside;
      else
        inside[index] += now_inside ? 1 : -1;
      now_inside = at(node, index);
      if (before == now_inside) return;
      first = node.first;
      index = node.parent;
    }
  }
};

// The crossings of one operand, a solid, with a line in the space of the CSG, and their error bounds there.
int operand_crossings(const Scene& scene, const Csg& csg, uint32_t operand, const Ray& line,
                      SolidCrossing out[kMaxSolidCrossings]);

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
