#include "scene/csg.h"

#include "base/counters.h"

namespace tilecast {
namespace {

// Kept from ray to ray, so that tracing does not allocate.
struct Workspace {
  std::vector<Crossing> events;       // not walked through yet, a heap with the first on top
  std::vector<Crossing> together;     // within their error bounds
  std::vector<uint32_t> touched;      // operands that were entered or left
  std::vector<uint32_t> inside;       // node: children inside; of a difference, subtracted children inside
  std::vector<uint8_t> first_inside;  // node: the first child is inside
  std::vector<int32_t> depth;         // operand: entries minus exits
  std::vector<Bvh::Pending> open;

  bool state(const Csg::Node& node, int index) const {
    switch (node.operation) {
      case CsgOperation::Union: return inside[index] > 0;
      case CsgOperation::Intersection: return inside[index] == node.children;
      default: return first_inside[index] && inside[index] == 0;
    }
  }

  void apply(const Csg& csg, const Crossing& event) {
    const Csg::Operand& operand = csg.operands[event.operand];
    touched.push_back(event.operand);
    bool was_inside = depth[event.operand] > 0;
    depth[event.operand] += event.entering ? 1 : -1;
    bool now_inside = depth[event.operand] > 0;
    if (was_inside == now_inside) return;
    bool first = operand.first;
    for (int index = operand.parent; index >= 0;) {
      const Csg::Node& node = csg.nodes[index];
      bool before = state(node, index);
      if (node.operation == CsgOperation::Difference && first)
        first_inside[index] = now_inside;
      else
        inside[index] += now_inside ? 1 : -1;
      now_inside = state(node, index);
      if (before == now_inside) return;
      first = node.first;
      index = node.parent;
    }
  }

  // Leaves all counters at zero for the next ray.
  void clear(const Csg& csg) {
    for (uint32_t operand : touched) {
      depth[operand] = 0;
      for (int node = csg.operands[operand].parent; node >= 0; node = csg.nodes[node].parent) {
        if (inside[node] == 0 && first_inside[node] == 0) break;
        inside[node] = 0, first_inside[node] = 0;
      }
    }
  }
};

Workspace& workspace() {
  thread_local Workspace space;
  return space;
}

// The order of the heap: the first event on top.
bool later(const Crossing& a, const Crossing& b) {
  if (a.t != b.t) return a.t > b.t;
  if (a.primitive != b.primitive) return a.primitive > b.primitive;
  return a.entering < b.entering;
}

}  // namespace

std::vector<Bvh::Pending>& CsgWalk::open() { return workspace().open; }

bool CsgWalk::begin(FrameRay& local, float& s_min, float& s_max) {
  TILECAST_COUNT(csg);
  if (!enter_frame(csg_.assembly.frame, line_, local)) return false;
  s_min = local.s_below(t_min_), s_max = local.s_above(t_max_);
  if (!clip_to_box(csg_.result_box.lo, csg_.result_box.hi, local, s_min, s_max)) return false;
  Workspace& space = workspace();
  space.events.clear();
  space.touched.clear();
  if (space.inside.size() < csg_.nodes.size()) {
    space.inside.resize(csg_.nodes.size());
    space.first_inside.resize(csg_.nodes.size());
  }
  if (space.depth.size() < csg_.operands.size()) space.depth.resize(csg_.operands.size());
  return true;
}

void CsgWalk::gather(uint32_t operand) {
  std::vector<Crossing>& events = workspace().events;
  const Instance& instance = csg_.assembly.instances[operand];
  size_t begin = events.size();
  // Operands meet in the space of the CSG; each has its own way there, with its own rounding: of the given map, of its
  // inverse and of the line's, relative to what they subtract.
  double relative = 16 * kUnitRoundoff * instance.to_local.stretch();
  LineError error{relative * (max_abs(line_.origin) + max_abs(instance.to_parent.offset)),
                  relative * max_abs(line_.direction)};
  crossings(scene_, scene_.objects[instance.object], instance.to_local.ray(line_),
            base_ + csg_.assembly.first_primitive[operand], events, error);
  for (size_t k = begin; k < events.size(); ++k) {
    events[k].operand = operand;
    events[k].entering ^= csg_.operands[operand].inside_out;
  }
  // Only now: crossings() may have put its own list in order.
  for (size_t k = begin; k < events.size(); ++k) std::push_heap(events.begin(), events.begin() + k + 1, later);
}

bool CsgWalk::next_event(double t_open, Crossing& surface, bool& changed) {
  Workspace& space = workspace();
  std::vector<Crossing>& events = space.events;
  std::vector<Crossing>& together = space.together;
  if (events.empty() || !(events.front().t + events.front().error < t_open)) return false;
  together.clear();
  do {
    std::pop_heap(events.begin(), events.end(), later);
    together.push_back(events.back());
    events.pop_back();
  } while (!events.empty() && events.front().t - together.back().t <= events.front().error + together.back().error);
  if (!(together.back().t + together.back().error < t_open)) {
    // What is not looked at yet may belong to it.
    for (const Crossing& event : together) {
      events.push_back(event);
      std::push_heap(events.begin(), events.end(), later);
    }
    return false;
  }
  const bool before = space.state(csg_.nodes[0], 0);
  // The first operand of the scene stands for all that coincide.
  surface = together.front();
  for (const Crossing& event : together) {
    space.apply(csg_, event);
    if (event.primitive < surface.primitive) surface = event;
  }
  surface.entering = !before;
  changed = space.state(csg_.nodes[0], 0) != before;
  return true;
}

void CsgWalk::end() { workspace().clear(csg_); }

}  // namespace tilecast
