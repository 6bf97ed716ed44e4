#include "scene/builder.h"

#include "base/built.h"
#include "base/check.h"
#include "optics/spectrum.h"

namespace tilecast {
namespace {

constexpr float kMostUv = 1e6f;
constexpr int kMostNesting = 1000;  // of groups in groups: bounds the traversal's recursion
constexpr const char* kUnbounded =
    "a halfspace has no end: intersect it with something that has, such as a box, or subtract it";

void check_colour(const Rgb& c, const char* name, double most) {
  for (int i = 0; i < 3; ++i)
    if (!(c[i] >= 0.0 && c[i] <= most))
      throw Error(std::string(name) + ": must lie between 0 and " + text(most) + ", got " + text(c[i]));
}

}  // namespace

SceneBuilder::SceneBuilder() { scene_.materials.emplace_back(); }

uint32_t SceneBuilder::add(Kind kind, size_t index, uint64_t primitives, const Box& bounds) {
  scene_.objects.push_back({kind, static_cast<uint32_t>(index), primitives, bounds});
  facts_.emplace_back();
  return static_cast<uint32_t>(scene_.objects.size() - 1);
}

uint32_t SceneBuilder::add_solid(const Solid& solid) {
  check(solid);
  scene_.solids.push_back(solid);
  uint32_t handle = add(Kind::Solid, scene_.solids.size() - 1, face_count(solid), bounds(solid));
  facts_[handle].checked_open = true;
  return handle;
}

uint32_t SceneBuilder::add_flat(const Flat& flat) {
  std::visit([](const auto& shape) { check(shape); }, flat);
  scene_.flats.push_back(flat);
  Box box = std::visit([](const auto& shape) { return bounds(shape); }, flat);
  uint32_t handle = add(Kind::Flat, scene_.flats.size() - 1, 1, box);
  facts_[handle].checked_open = true;
  std::string name = std::holds_alternative<Disk>(flat) ? "disk" : "rectangle";
  facts_[handle].open = "a " + name + " is open, and CSG needs closed objects";
  return handle;
}

uint32_t SceneBuilder::add_mesh(Mesh mesh, const AcceleratorChoice& choice, std::vector<FaceUvs> uvs) {
  Box box = mesh.bounds;
  uint64_t faces = mesh.faces.size();
  if (!uvs.empty() && uvs.size() != faces) throw Error("uvs: each face needs those of its three corners");
  for (size_t i = 0; i < uvs.size(); ++i)
    for (const glm::vec2& uv : uvs[i])
      if (!(std::fabs(uv.x) <= kMostUv && std::fabs(uv.y) <= kMostUv))
        throw Error("uvs: must lie between -1e6 and 1e6, but face " + std::to_string(i) + " has (" + text(uv.x) + ", " +
                    text(uv.y) + ")");
  scene_.mesh_uvs.push_back(std::move(uvs));
  scene_.meshes.emplace_back(std::move(mesh), choice);
  return add(Kind::Mesh, scene_.meshes.size() - 1, faces, box);
}

std::vector<Instance> SceneBuilder::place(const std::vector<InstanceSource>& sources, const char* list) const {
  std::vector<Instance> out;
  out.reserve(sources.size());
  for (size_t i = 0; i < sources.size(); ++i) {
    const InstanceSource& source = sources[i];
    std::string where = std::string(list) + "[" + std::to_string(i) + "]";
    if (source.object >= scene_.objects.size()) throw Error(where + ": no such object");
    if (source.material >= static_cast<int>(scene_.materials.size()) || source.material < kInherit)
      throw Error(where + ".material: no such material");
    try {
      out.push_back({source.object, source.material, source.transform, inverse(source.transform)});
    } catch (const Error& error) {
      throw Error(where + ".transform: " + error.what());
    }
    if (!(max_abs(source.transform.offset) <= 1e100 && source.transform.stretch() <= 1e100))
      throw Error(where + ".transform: values must be at most 1e100");
  }
  return out;
}

void SceneBuilder::note_instances(uint32_t object, const std::vector<Instance>& instances) {
  Facts& facts = facts_[object];
  facts.inherits = false;
  for (const Instance& instance : instances) {
    const Facts& part = facts_[instance.object];
    facts.depth = std::max(facts.depth, part.depth);
    facts.has_emitter |= part.has_emitter ||
                         (instance.material != kInherit && scene_.materials[instance.material].emits());
    facts.inherits |= instance.material == kInherit && part.inherits;
  }
}

uint32_t SceneBuilder::add_csg(CsgOperation operation, const std::vector<InstanceSource>& sources) {
  if (sources.size() < 2) throw Error("of: CSG needs at least 2 operands, got " + std::to_string(sources.size()));
  std::vector<Instance> operands = place(sources, "of");
  Box box;
  uint64_t primitives = 0;
  for (size_t i = 0; i < operands.size(); ++i) {
    const std::string& open = why_open(operands[i].object);
    if (!open.empty()) throw Error("of[" + std::to_string(i) + "]: " + open);
    Box part = operands[i].to_parent.box(scene_.objects[operands[i].object].bounds);
    if (i == 0 || operation == CsgOperation::Union) {
      box.extend(part);
    } else if (operation == CsgOperation::Intersection) {
      box.lo = glm::max(box.lo, part.lo);
      box.hi = glm::min(box.hi, part.hi);
    }
    primitives += scene_.objects[operands[i].object].primitives;
    if (primitives > uint64_t(1) << 62) throw Error("instances multiply to more than 2^62 primitives");
  }
  if (box.empty()) box = Box{};
  scene_.csgs.emplace_back();
  csg_sources_.push_back({operation, std::move(operands)});
  uint32_t handle = add(Kind::Csg, scene_.csgs.size() - 1, primitives, box);
  facts_[handle].checked_open = true;
  note_instances(handle, csg_sources_.back().operands);
  return handle;
}

uint32_t SceneBuilder::add_group(const std::vector<InstanceSource>& sources, const AcceleratorChoice& choice) {
  for (size_t i = 0; i < sources.size(); ++i)
    if (sources[i].object < scene_.objects.size() && scene_.objects[sources[i].object].bounds.unbounded())
      throw Error("of[" + std::to_string(i) + "]: " + kUnbounded);
  Assembly assembly = Assembly::build(place(sources, "of"), scene_.objects, choice, true);
  Box box = assembly.bounds;
  uint64_t primitives = assembly.primitives(scene_.objects);
  scene_.groups.push_back(std::move(assembly));
  uint32_t handle = add(Kind::Group, scene_.groups.size() - 1, primitives, box);
  note_instances(handle, scene_.groups.back().instances);
  if (++facts_[handle].depth > kMostNesting)
    throw Error("groups are nested deeper than " + std::to_string(kMostNesting));
  return handle;
}

const std::string& SceneBuilder::why_open(uint32_t object) {
  Facts& facts = facts_[object];
  if (facts.checked_open) return facts.open;
  facts.checked_open = true;
  if (scene_.objects[object].kind == Kind::Mesh) {
    if (auto edge = find_open_edge(scene_.meshes[scene_.objects[object].index].mesh()))
      facts.open = "the mesh is not closed, and CSG needs closed objects: " + *edge;
  } else {  // a group
    const auto& instances = scene_.groups[scene_.objects[object].index].instances;
    for (size_t i = 0; i < instances.size() && facts_[object].open.empty(); ++i) {
      const std::string& open = why_open(instances[i].object);
      if (!open.empty()) facts_[object].open = "of[" + std::to_string(i) + "]: " + open;
    }
  }
  return facts_[object].open;
}

int SceneBuilder::add_material(const Material& given) {
  Material m = given;
  auto fraction = [](double x, const char* name) {
    if (!(x >= 0.0 && x <= 1.0)) throw Error(std::string(name) + ": must lie between 0 and 1, got " + text(x));
  };
  check_colour(m.reflectance, "reflectance", 1.0);
  check_colour(m.tint, "tint", 1.0);
  check_colour(m.absorption, "absorption", 1e100);
  check_colour(m.emission, "emission", 1e30);
  check_colour(m.specular, "specular", 1.0);
  check_colour(m.eta, "eta", 1e3);
  check_colour(m.k, "k", 1e3);
  fraction(m.roughness, "roughness");
  fraction(m.opacity, "opacity");
  if (!(m.ior >= kLeastIor && m.ior <= 1e3)) throw Error("ior: must lie between 0.001 and 1000, got " + text(m.ior));
  if (m.kind == MaterialKind::Plastic && m.ior < 1.0) throw Error("ior: must be at least 1, got " + text(m.ior));
  if (!(m.exponent >= 0.0 && m.exponent <= 1e6))
    throw Error("exponent: must lie between 0 and 1e6, got " + text(m.exponent));
  if (m.abbe != 0.0) {
    if (!(m.abbe >= 1.0 && m.abbe <= 1e6)) throw Error("abbe: must lie between 1 and 1e6, got " + text(m.abbe));
    if (!m.smooth()) throw Error("abbe: is for polished surfaces alone, and this has a roughness of " + text(m.roughness));
    if (const double least = least_ior(m.ior, m.abbe); least < kLeastIor)
      throw Error("abbe: must be greater for an ior of " + text(m.ior) + ", as the index of refraction of violet light " +
                  "would be " + text(least) + ": it must be at least 0.001");
    m.dispersion = cauchy_coefficient(m.ior, m.abbe);
  }
  apply_textures(m);
  if (m.kind == MaterialKind::Phong) {
    const Rgb most = m.texture >= 0 ? tilecast::most(scene_.textures[m.texture]) : m.reflectance;
    for (int i = 0; i < 3; ++i)
      if (double sum = most[i] + m.specular[i]; sum > 1.0 + 4 * kUnitRoundoff)
        throw Error("specular[" + std::to_string(i) + "]: must be at most 1 together with the reflectance, is " + text(sum));
  }
  if (m.eta.x > 0.0)
    for (int i = 0; i < 3; ++i) {
      if (!(m.eta[i] >= 1e-3))
        throw Error("eta[" + std::to_string(i) + "]: must be at least 0.001, got " + text(m.eta[i]));
      m.average[i] = average_reflectance(m.eta[i], m.k[i]);
    }
  m.refracts = m.kind == MaterialKind::Dielectric;
  if (m.kind == MaterialKind::Blend) blend(m);
  scene_.materials.push_back(m);
  return static_cast<int>(scene_.materials.size() - 1);
}

namespace {

void check_position(const Vec3& position) {
  if (!(max_abs(position) <= 1e100)) throw Error("position: must be finite and at most 1e100");
}

Vec3 checked_direction(const Vec3& direction) {
  if (!(max_abs(direction) > 0.0) || !is_finite(direction)) throw Error("direction: must be finite and not zero");
  return glm::normalize(direction / max_abs(direction));
}

}  // namespace

void SceneBuilder::add_point_light(const PointLight& light) {
  check_colour(light.intensity, "intensity", 1e30);
  check_position(light.position);
  if (max_component(light.intensity) > 0.0) scene_.lights.points.push_back(light);
}

void SceneBuilder::add_spot_light(const SpotLight& light) {
  check_colour(light.intensity, "intensity", 1e30);
  check_position(light.position);
  if (!(light.cos_inner <= 1.0 && light.cos_outer >= -1.0 && light.cos_outer <= light.cos_inner))
    throw Error("inner_angle: must be at most outer_angle");
  SpotLight spot = light;
  spot.direction = checked_direction(light.direction);
  if (max_component(light.intensity) > 0.0 && light.cos_outer < 1.0) scene_.lights.spots.push_back(spot);
}

void SceneBuilder::add_directional_light(const DirectionalLight& light) {
  check_colour(light.irradiance, "irradiance", 1e30);
  const Vec3 direction = checked_direction(light.direction);
  if (max_component(light.irradiance) > 0.0) scene_.lights.directionals.push_back({direction, light.irradiance});
}

void SceneBuilder::set_background(const Rgb& radiance) {
  check_colour(radiance, "background", 1e30);
  scene_.background = radiance;
  scene_.lights.environment = nullptr;
}

void SceneBuilder::set_environment(Environment environment) {
  set_background(Rgb(0.0));
  if (!environment.black()) scene_.lights.environment = std::make_shared<const Environment>(std::move(environment));
}

std::shared_ptr<const Scene> SceneBuilder::build(uint32_t root, const Options& options) {
  if (root >= scene_.objects.size()) throw Error("root: no such object");
  if (scene_.objects[root].bounds.unbounded()) throw Error(std::string("root: ") + kUnbounded);
  if (options.max_depth < 1) throw Error("max_depth: must be at least 1");
  scene_.root = root;
  scene_.integrator = options.integrator;
  scene_.max_depth = options.max_depth;
  scene_.seed = options.seed;
  scene_.next_event = options.next_event;
  scene_.sampling = options.sampling;
  scene_.roulette = options.roulette;
  if (!(options.contrast >= 0.0)) throw Error("contrast: must not be negative, got " + text(options.contrast));
  scene_.contrast = options.contrast;
  if (!(options.ao_distance > 0.0)) throw Error("ao_distance: must be positive, got " + text(options.ao_distance));
  scene_.ao_distance = options.ao_distance;
  drop_unused_uvs(root);
  finish_reachable();
  if (traces_light(options.integrator)) {
    finish_materials();
    collect_lights(root, Affine{}, kInherit, 0);
  } else {
    scene_.lights = {};
  }
  scene_.lights.finish();
  scene_.features = find_features(scene_);
  for (const std::string& feature : scene_.features)
    if (among(kLeftOut, feature)) throw Error("the core is built without " + feature + ", which the scene uses");
  auto uses = [&](const char* name) { return std::binary_search(scene_.features.begin(), scene_.features.end(), name); };
  scene_.dielectrics = uses("dielectric");
  scene_.disperses = uses("dispersion");
  scene_.see_through = uses("opacity");
  auto out = std::make_shared<const Scene>(std::move(scene_));
  *this = SceneBuilder();
  return out;
}

}  // namespace tilecast
