// The last steps of building: CSG trees flattened, lights collected, statistics summed.
#include <numeric>

#include "scene/builder.h"

namespace tilecast {
namespace {
constexpr size_t kMostOperands = 10'000'000;  // of one CSG, nested ones multiplied out
// Further emitters are met by chance alone, which is slower but not wrong. Pieces: a mesh's triangles; an emitter that is no
// light, as a box, counts as one.
constexpr size_t kMostLights = 1'000'000, kMostLightPieces = 10'000'000;

// Whether a map keeps all angles: then it maps a ball to a ball. Up to what multiplying a few rotations loses.
bool keeps_angles(const glm::dmat3& m) {
  const double size = glm::dot(m[0], m[0]), room = 64 * kUnitRoundoff * size;
  for (int i = 0; i < 3; ++i)
    if (!(std::fabs(glm::dot(m[i], m[i]) - size) <= room && std::fabs(glm::dot(m[i], m[(i + 1) % 3])) <= room)) return false;
  return true;
}

}  // namespace

// A halfspace as an operand: a solid that ends well outside of what the CSG may fill, given in the operand's space.
uint32_t SceneBuilder::cut_off(uint32_t handle, const Box& box) {
  Halfspace halfspace = std::get<Halfspace>(scene_.solids[scene_.objects[handle].index]);
  halfspace.lo = box.lo;
  halfspace.hi = box.hi;
  return add_solid(halfspace);
}

// Depth first with a stack of its own: a chain of 1e5 operations must not overflow the thread's.
Csg SceneBuilder::flatten(const CsgSource& source, const Box& bounds) {
  Csg csg;
  Box around = bounds;
  if (!bounds.empty()) {
    double margin = max_component(bounds.hi - bounds.lo) + 0x1p-20 * std::max(max_abs(bounds.lo), max_abs(bounds.hi));
    around.lo -= margin, around.hi += margin;
  }
  std::vector<Instance> operands;
  csg.nodes.push_back({source.operation, -1, static_cast<uint32_t>(source.operands.size()), true});
  struct Task {
    Instance instance;
    int parent;
    bool first;
  };
  std::vector<Task> tasks;
  auto push = [&](const std::vector<Instance>& children, const Instance* outer, int material, int parent) {
    for (size_t i = children.size(); i-- > 0;) {  // last first: operands come out in order
      Instance child = children[i];
      if (outer) {  // the inverses, too: each of them was found to be sound, and no new one can turn out singular
        child.to_parent = outer->to_parent * child.to_parent;
        child.to_local = {child.to_local.linear * outer->to_local.linear, child.to_parent.offset};
      }
      if (child.material == kInherit) child.material = material;
      tasks.push_back({child, parent, i == 0});
    }
  };
  push(source.operands, nullptr, kInherit, 0);
  while (!tasks.empty()) {
    Task task = tasks.back();
    tasks.pop_back();
    const Object object = scene_.objects[task.instance.object];
    if (object.primitives == 0) continue;  // its node has one child that nothing is ever inside of
    if (object.kind == Kind::Csg || object.kind == Kind::Group) {
      bool is_group = object.kind == Kind::Group;
      const auto& children = is_group ? scene_.groups[object.index].instances : csg_sources_[object.index].operands;
      csg.nodes.push_back({is_group ? CsgOperation::Union : csg_sources_[object.index].operation, task.parent,
                           static_cast<uint32_t>(children.size()), task.first});
      push(children, &task.instance, task.instance.material, static_cast<int>(csg.nodes.size() - 1));
    } else {
      bool inside_out = object.kind == Kind::Mesh && signed_volume(scene_.meshes[object.index].mesh()) < 0.0;
      csg.operands.push_back({task.parent, task.first, inside_out,
                              16 * kUnitRoundoff * task.instance.to_local.stretch()});
      if (object.bounds.unbounded())
        task.instance.object = cut_off(task.instance.object, task.instance.to_local.box(around));
      operands.push_back(task.instance);
    }
    if (operands.size() + tasks.size() + csg.nodes.size() > kMostOperands) throw Error("a CSG has more than 1e7 operands, nested ones multiplied out");
  }
  csg.assembly = Assembly::build(std::move(operands), scene_.objects, "bvh", false);
  if (!bounds.empty()) csg.result_box = FrameBox::around(csg.assembly.frame, bounds);
  csg.filter = make_filter(csg, scene_);
  return csg;
}

void SceneBuilder::finish_reachable() {
  std::vector<bool> seen(scene_.objects.size());
  std::vector<uint32_t> pending{scene_.root};
  AcceleratorStats& total = scene_.accelerator;
  std::vector<std::string> kinds;  // chosen for meshes and groups; a CSG always has a bvh over its operands
  auto count = [&](const Accelerator& accelerator, uint64_t bytes, bool chosen) {
    const std::string& kind = accelerator.stats().kind;
    if (chosen && kind != "none" && std::find(kinds.begin(), kinds.end(), kind) == kinds.end()) kinds.push_back(kind);
    total.nodes += accelerator.stats().nodes;
    total.references += accelerator.stats().references;
    total.bytes += bytes;
    total.seconds += accelerator.stats().seconds;
  };
  while (!pending.empty()) {
    const Object object = scene_.objects[pending.back()];  // flattening adds objects
    seen.resize(scene_.objects.size());
    bool again = seen[pending.back()];
    seen[pending.back()] = true;
    pending.pop_back();
    if (again) continue;
    if (object.kind == Kind::Mesh) {
      count(scene_.meshes[object.index].accelerator(), scene_.meshes[object.index].bytes(), true);
    } else if (object.kind == Kind::Csg) {
      Csg& csg = scene_.csgs[object.index] = flatten(csg_sources_[object.index], object.bounds);
      count(csg.assembly.accelerator, csg.assembly.accelerator.stats().bytes, false);
      for (const Instance& operand : csg.assembly.instances) pending.push_back(operand.object);
    } else if (object.kind == Kind::Group) {
      const Assembly& group = scene_.groups[object.index];
      count(group.accelerator, group.accelerator.stats().bytes, true);
      for (const Instance& instance : group.instances) pending.push_back(instance.object);
    }
  }
  for (const std::string& kind : kinds) total.kind += (total.kind.empty() ? "" : " + ") + kind;
  if (kinds.empty()) total.kind = "none";
  total.cost = expected_cost(scene_.root);
}

// Steps and tests that a line through the object's bounds is expected to cost, all levels below it included. Objects
// are built before those that hold them, so one pass in their order is enough.
double SceneBuilder::expected_cost(uint32_t handle) const {
  auto half_area = [](const Box& b) {
    Vec3 d = b.hi - b.lo;
    return b.empty() ? 0.0 : d.x * d.y + d.y * d.z + d.z * d.x;
  };
  std::vector<double> cost(scene_.objects.size(), 0.0);
  for (uint32_t i = 0; i <= handle; ++i) {
    const Object& object = scene_.objects[i];
    if (object.kind == Kind::Mesh) cost[i] = scene_.meshes[object.index].accelerator().stats().cost;
    if (object.kind != Kind::Group && object.kind != Kind::Csg) continue;
    const Assembly& assembly =
        object.kind == Kind::Group ? scene_.groups[object.index] : scene_.csgs[object.index].assembly;
    if (assembly.instances.empty()) continue;
    cost[i] = assembly.accelerator.stats().cost;
    const double whole = half_area(assembly.bounds);
    for (const Instance& instance : assembly.instances) {
      double part = half_area(instance.to_parent.box(scene_.objects[instance.object].bounds));
      if (whole > 0.0) cost[i] += part / whole * cost[instance.object];
    }
  }
  return cost[handle];
}

void SceneBuilder::collect_lights(uint32_t handle, const Affine& to_world, int material, uint64_t base) {
  const Object& object = scene_.objects[handle];
  bool emits = material != kInherit && scene_.materials[material].emits();
  if (object.primitives == 0 || (!(emits && facts_[handle].inherits) && !facts_[handle].has_emitter)) return;
  if (scene_.lights.areas.size() >= kMostLights || light_pieces_ >= kMostLightPieces) return;
  if (object.kind == Kind::Group) {
    const Assembly& group = scene_.groups[object.index];
    for (size_t i = 0; i < group.instances.size(); ++i) {
      const Instance& instance = group.instances[i];
      collect_lights(instance.object, to_world * instance.to_parent,
                     instance.material == kInherit ? material : instance.material, base + group.first_primitive[i]);
    }
    return;
  }
  light_pieces_ += object.kind == Kind::Mesh ? object.primitives : 1;
  if (light_pieces_ > kMostLightPieces) return;
  AreaLight light;
  light.radiance = Rgb(0.0);
  const Material* shining = material != kInherit ? &scene_.materials[material] : nullptr;
  if (shining && (shining->emission_texture >= 0 || shining->opacity_texture >= 0)) return;  // met by chance
  if (shining) light.radiance = shining->emission * shining->opacity;
  if (shining && shining->refracts) light.refracting = material;
  light.first_primitive = base;
  light.primitives = object.primitives;
  double mirrored = glm::determinant(to_world.linear) < 0.0 ? -1.0 : 1.0;
  if (object.kind == Kind::Flat) {
    const Flat& flat = scene_.flats[object.index];
    if (auto* r = std::get_if<Rectangle>(&flat)) {
      light.pieces.push_back({to_world.point({-0.5 * r->width, 0.0, -0.5 * r->depth}),
                              to_world.vector({0.0, 0.0, r->depth}), to_world.vector({r->width, 0.0, 0.0})});
    } else {
      double radius = std::get<Disk>(flat).radius;
      light.shape = AreaLight::Shape::Ellipse;
      light.pieces.push_back({to_world.point(Vec3(0.0)), to_world.vector({0.0, 0.0, radius}),
                              to_world.vector({radius, 0.0, 0.0})});
    }
    light.flip = mirrored;
  } else if (object.kind == Kind::Mesh) {
    const Mesh& mesh = scene_.meshes[object.index].mesh();
    light.shape = AreaLight::Shape::Triangle;
    light.flip = mirrored;
    light.sideways = mesh.frame.sideways_error() * to_world.stretch();
    for (uint32_t face = 0; face < mesh.faces.size(); ++face) {
      Triangle t = mesh.triangle(face);
      Vec3 a = to_world.point(mesh.frame.from_frame(Vec3(t.a)));
      light.pieces.push_back({a, to_world.point(mesh.frame.from_frame(Vec3(t.b))) - a,
                              to_world.point(mesh.frame.from_frame(Vec3(t.c))) - a});
    }
  } else if (const Sphere* ball = object.kind == Kind::Solid ? std::get_if<Sphere>(&scene_.solids[object.index]) : nullptr;
             ball && keeps_angles(to_world.linear)) {
    light.shape = AreaLight::Shape::Ball;
    light.pieces.push_back({to_world.point(Vec3(0.0)), to_world.vector({ball->radius, 0.0, 0.0}), Vec3(0.0)});
    light.cumulative.push_back(4.0 * kPi * light.radius() * light.radius());
    if (light.area() > 0.0) scene_.lights.areas.push_back(std::move(light));
    return;
  } else {
    return;  // other solids and CSG are met by chance
  }
  double sum = 0.0;
  double share = light.shape == AreaLight::Shape::Triangle ? 0.5 : light.shape == AreaLight::Shape::Ellipse ? kPi : 1.0;
  for (const AreaLight::Piece& piece : light.pieces)
    light.cumulative.push_back(sum += share * glm::length(glm::cross(piece.edge1, piece.edge2)));
  if (sum > 0.0 && max_component(light.radiance) > 0.0) scene_.lights.areas.push_back(std::move(light));
}

}  // namespace tilecast
