#include "scene/csg.h"

#include "base/counters.h"

namespace tilecast {
namespace {

// Kept from ray to ray, so that tracing does not allocate.
struct Walk {
  std::vector<Crossing> events, result;
  std::vector<uint32_t> inside;      // node: children inside; of a difference, subtracted children inside
  std::vector<uint8_t> first_inside;  // node: the first child is inside
  std::vector<int32_t> depth;        // operand: entries minus exits

  void prepare(const Csg& csg) {
    events.clear();
    result.clear();
    if (inside.size() < csg.nodes.size()) inside.resize(csg.nodes.size()), first_inside.resize(csg.nodes.size());
    if (depth.size() < csg.operands.size()) depth.resize(csg.operands.size());
  }

  // Leaves all counters at zero for the next ray, even where an operand was not crossed evenly.
  void clear(const Csg& csg) {
    for (const Crossing& event : events) {
      depth[event.operand] = 0;
      for (int node = csg.operands[event.operand].parent; node >= 0; node = csg.nodes[node].parent) {
        if (inside[node] == 0 && first_inside[node] == 0) break;
        inside[node] = 0, first_inside[node] = 0;
      }
    }
  }

  bool state(const Csg::Node& node, int index) const {
    switch (node.operation) {
      case CsgOperation::Union: return inside[index] > 0;
      case CsgOperation::Intersection: return inside[index] == node.children;
      default: return first_inside[index] && inside[index] == 0;
    }
  }

  void apply(const Csg& csg, const Crossing& event) {
    const Csg::Operand& operand = csg.operands[event.operand];
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
};

bool earlier(const Crossing& a, const Crossing& b) {
  if (a.t != b.t) return a.t < b.t;
  if (a.primitive != b.primitive) return a.primitive < b.primitive;
  return a.entering > b.entering;
}

}  // namespace

const std::vector<Crossing>& crossings(const Scene& scene, const Csg& csg, const Ray& line, uint64_t base) {
  TILECAST_COUNT(csg);
  thread_local Walk walk;
  walk.prepare(csg);
  const Assembly& assembly = csg.assembly;
  FrameRay local;
  if (!enter_frame(assembly.frame, line, local)) return walk.result;
  const float infinity = std::numeric_limits<float>::infinity();
  assembly.accelerator.traverse(local, -infinity, infinity, [&](uint32_t first, uint32_t count) {
    for (uint32_t i = first; i < first + count; ++i) {
      uint32_t operand = assembly.accelerator.order()[i];
      const Instance& instance = assembly.instances[operand];
      size_t begin = walk.events.size();
      crossings(scene, scene.objects[instance.object], instance.to_local.ray(line),
                base + assembly.first_primitive[operand], walk.events);
      for (size_t k = begin; k < walk.events.size(); ++k) {
        walk.events[k].operand = operand;
        walk.events[k].entering ^= csg.operands[operand].inside_out;
      }
    }
    return false;
  });
  std::sort(walk.events.begin(), walk.events.end(), earlier);

  const Csg::Node& root = csg.nodes[0];
  bool state = false;
  for (size_t i = 0; i < walk.events.size();) {
    size_t end = i + 1;
    walk.apply(csg, walk.events[i]);
    while (end < walk.events.size() &&
           walk.events[end].t - walk.events[end - 1].t <= walk.events[end].error + walk.events[end - 1].error)
      walk.apply(csg, walk.events[end++]);
    bool now = walk.state(root, 0);
    if (now != state) {
      state = now;
      // The first operand of the scene stands for all that coincide.
      Crossing surface = walk.events[i];
      for (size_t k = i + 1; k < end; ++k)
        if (walk.events[k].primitive < surface.primitive) surface = walk.events[k];
      surface.entering = now;
      walk.result.push_back(surface);
    }
    i = end;
  }
  walk.clear(csg);
  return walk.result;
}

}  // namespace tilecast
