#include <algorithm>
#include <chrono>

#include "scene/object.h"

namespace tilecast {
namespace {
constexpr float kInstanceCost = 4.0f;  // the ray goes into its space first
constexpr uint64_t kMostPrimitives = uint64_t(1) << 62;
constexpr int kMostFlatsWithoutBoxes = 3;

// A flat is asked faster than its box; meshes, CSG and groups look at a box of their own first.
bool none_is_worth_a_box(const std::vector<Instance>& instances, const std::vector<Object>& objects) {
  int flats = 0, others = 0;
  for (const Instance& instance : instances) {
    const Kind kind = objects[instance.object].kind;
    if (kind == Kind::Solid) return false;
    ++(kind == Kind::Flat ? flats : others);
  }
  return flats <= kMostFlatsWithoutBoxes && others <= 1;
}

}  // namespace

Assembly Assembly::build(std::vector<Instance> instances, const std::vector<Object>& objects,
                         const AcceleratorChoice& choice, bool fold) {
  Assembly out;
  out.instances = std::move(instances);
  std::vector<Box> boxes;
  boxes.reserve(out.instances.size());
  uint64_t total = 0;
  for (Instance& instance : out.instances) {
    const glm::dmat3 same(1.0);
    instance.turned = instance.to_parent.linear != same || instance.to_local.linear != same;
    instance.stretch = instance.to_parent.stretch();
    const Object& object = objects[instance.object];
    out.first_primitive.push_back(total);
    if (object.primitives > kMostPrimitives - total) throw Error("instances multiply to more than 2^62 primitives");
    total += object.primitives;
    Box box = instance.to_parent.box(object.bounds);
    // Room for the rounding of the transforms, there and back.
    double slack = 16 * kUnitRoundoff * std::max(max_abs(box.lo), max_abs(box.hi));
    if (!box.empty()) box.lo -= slack, box.hi += slack;
    boxes.push_back(box);
    out.bounds.extend(box);
  }
  out.frame = Frame::around(out.bounds);
  out.all_at_once = none_is_worth_a_box(out.instances, objects);
  std::vector<FrameBox> frame_boxes;
  frame_boxes.reserve(boxes.size());
  for (const Box& box : boxes)
    frame_boxes.push_back(FrameBox::around(out.frame, box.empty() ? Box{out.frame.centre, out.frame.centre} : box));
  if (frame_boxes.size() <= kLanes)
    for (size_t i = 0; i < frame_boxes.size(); ++i) out.few.set(static_cast<int>(i), frame_boxes[i].padded(static_cast<float>(kRoom)));
  PrimitiveSet primitives;
  primitives.boxes = frame_boxes;
  primitives.test_cost = kInstanceCost;
  out.accelerator = Accelerator::build(choice, primitives);
  if (fold && out.accelerator.is_hierarchy()) {
    const auto start = std::chrono::steady_clock::now();
    out.wide = WideBoxes::fold(out.accelerator.hierarchy(), out.accelerator.order(), frame_boxes);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    out.accelerator.give_way(out.wide->node_count(), out.wide->bytes(), seconds.count());
  }
  return out;
}

uint64_t Assembly::primitives(const std::vector<Object>& objects) const {
  return instances.empty() ? 0 : first_primitive.back() + objects[instances.back().object].primitives;
}

uint32_t Assembly::find(uint64_t primitive) const {
  if (first_primitive.size() <= kLanes) {  // without a branch that is taken by chance
    uint32_t i = 0;
    for (size_t k = 1; k < first_primitive.size(); ++k) i += first_primitive[k] <= primitive;
    return i;
  }
  // By proportion first, which finds it where all instances hold as many.
  const size_t count = first_primitive.size();
  auto holds = [&](size_t i) {
    return i < count && first_primitive[i] <= primitive && (i + 1 == count || primitive < first_primitive[i + 1]);
  };
  if (const double last = static_cast<double>(first_primitive.back()); last > 0.0) {
    const double share = std::min(static_cast<double>(primitive) * (static_cast<double>(count - 1) / last),
                                  static_cast<double>(count));
    for (size_t i = static_cast<size_t>(share), after = i + 1; i <= after; ++i)
      if (holds(i)) return static_cast<uint32_t>(i);
  }
  auto next = std::upper_bound(first_primitive.begin(), first_primitive.end(), primitive);
  return static_cast<uint32_t>(next - first_primitive.begin() - 1);
}

}  // namespace tilecast
