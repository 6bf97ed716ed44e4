#include "scene/csg.h"

#include "base/counters.h"

namespace tilecast {
namespace {

// Kept from ray to ray, so that tracing does not allocate.
struct Workspace {
  std::vector<Crossing> events;       // not walked through yet, a heap with the first on top
  std::vector<Crossing> together;     // at one place, within their error bounds
  std::vector<uint8_t> was_inside;    // operand: before these
  std::vector<uint32_t> touched;      // operands that were entered or left
  std::vector<uint32_t> inside;       // node: children inside; of a difference, subtracted children inside
  std::vector<uint8_t> first_inside;  // node: the first child is inside
  std::vector<int32_t> depth;         // operand: entries minus exits
  std::vector<Bvh::Pending> open;

  CsgState state() { return {inside.data(), first_inside.data()}; }
  bool root_inside(const Csg& csg) { return state().at(csg.nodes[0], 0); }

  void note(const Crossing& event) { was_inside[event.operand] = depth[event.operand] > 0; }
  bool passed(const Crossing& event) const { return was_inside[event.operand] != (depth[event.operand] > 0); }

  void apply(const Csg& csg, const Crossing& event) {
    touched.push_back(event.operand);
    bool was_inside = depth[event.operand] > 0;
    depth[event.operand] += event.entering ? 1 : -1;
    bool now_inside = depth[event.operand] > 0;
    if (was_inside != now_inside) state().enter(csg, event.operand, now_inside);
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

double earliest(const Crossing& event) { return event.t - event.error; }
double latest(const Crossing& event) { return event.t + event.error; }

// The order of the heap: the event that may come first on top.
bool later(const Crossing& a, const Crossing& b) {
  if (earliest(a) != earliest(b)) return earliest(a) > earliest(b);
  if (a.t != b.t) return a.t > b.t;
  if (a.primitive != b.primitive) return a.primitive > b.primitive;
  return a.entering < b.entering;
}

// Operands meet in the space of the CSG; each has its own way there, with its own rounding: of the given map, of its
// inverse and of the line's, relative to what they subtract.
LineError line_error(const Csg& csg, uint32_t operand, const Ray& line) {
  double relative = csg.operands[operand].rounding;
  double offset = max_abs(csg.assembly.instances[operand].to_parent.offset);
  return {relative * (max_abs(line.origin) + offset), relative * max_abs(line.direction)};
}

}  // namespace

int operand_crossings(const Scene& scene, const Csg& csg, uint32_t operand, const Ray& line,
                      SolidCrossing out[kMaxSolidCrossings]) {
  TILECAST_COUNT(solid);
  const Instance& instance = csg.assembly.instances[operand];
  return solid_crossings(scene, scene.objects[instance.object], instance.local(line),
                         line_error(csg, operand, line), out);
}

std::vector<Bvh::Pending>& CsgWalk::open() { return workspace().open; }

bool CsgWalk::begin(FrameRay& local, float& s_min, float& s_max) {
  TILECAST_COUNT(csg);
  if (csg_.operands.empty()) return false;  // nor is there a hierarchy of them
  if (!enter_boxes(csg_.assembly.frame, line_, local)) return false;
  s_min = local.s_below(t_min_), s_max = local.s_above(t_max_);
  if (!clip_to_box(csg_.result_box.lo, csg_.result_box.hi, local, s_min, s_max)) return false;
  Workspace& space = workspace();
  space.events.clear();
  space.touched.clear();
  if (space.inside.size() < csg_.nodes.size()) {
    space.inside.resize(csg_.nodes.size());
    space.first_inside.resize(csg_.nodes.size());
  }
  if (space.depth.size() < csg_.operands.size()) {
    space.depth.resize(csg_.operands.size());
    space.was_inside.resize(csg_.operands.size());
  }
  return true;
}

void CsgWalk::gather(uint32_t operand) {
  std::vector<Crossing>& events = workspace().events;
  const Instance& instance = csg_.assembly.instances[operand];
  size_t begin = events.size();
  crossings(scene_, scene_.objects[instance.object], instance.local(line_),
            base_ + csg_.assembly.first_primitive[operand], events, line_error(csg_, operand, line_));
  for (size_t k = begin; k < events.size(); ++k) {
    events[k].operand = operand;
    events[k].entering ^= csg_.operands[operand].inside_out;
  }
  // Only now: crossings() may have put its own list in order.
  for (size_t k = begin; k < events.size(); ++k) std::push_heap(events.begin(), events.begin() + k + 1, later);
}

// Events that may all be at one place, the first by which one of them has happened, are together. (Not those that only a
// third one, of which less is known, overlaps both of: a line that grazes a face tells little about where it crosses it.)
bool CsgWalk::next_event(double t_open, Crossing& surface, bool& changed) {
  Workspace& space = workspace();
  std::vector<Crossing>& events = space.events;
  std::vector<Crossing>& together = space.together;
  together.clear();
  double by = t_open;
  while (!events.empty() && earliest(events.front()) <= by) {
    std::pop_heap(events.begin(), events.end(), later);
    together.push_back(events.back());
    events.pop_back();
    by = std::min(by, latest(together.back()));
  }
  if (!(by < t_open)) {
    // What is not looked at yet may belong to it.
    for (const Crossing& event : together) {
      events.push_back(event);
      std::push_heap(events.begin(), events.end(), later);
    }
    return false;
  }
  const bool before = space.root_inside(csg_);
  for (const Crossing& event : together) space.note(event);
  for (const Crossing& event : together) space.apply(csg_, event);
  // Of the operands that were entered or left, the first of the scene stands for all that coincide.
  surface.primitive = ~uint64_t(0);
  for (const Crossing& event : together)
    if (space.passed(event) && event.primitive < surface.primitive) surface = event;
  surface.t = std::min(surface.t, by);  // before all that follows
  surface.entering = !before;
  changed = space.root_inside(csg_) != before;
  return true;
}

void CsgWalk::end() { workspace().clear(csg_); }

}  // namespace tilecast
