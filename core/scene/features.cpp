#include <set>

#include "scene/plain_scene.h"

namespace tilecast {

const std::vector<std::string>& all_features() {
  static const std::vector<std::string> names{
      "absorption", "area_lights", "background", "blend", "conductor", "csg", "dielectric", "diffuse",
      "directional_lights", "disk", "dispersion", "emission", "environment", "hierarchy", "image_texture", "instances", "lens",
      "light_tree", "mesh", "microfacets", "mirror", "normal_map", "opacity", "oren_nayar", "phong", "pixel_filter", "plastic", "point_lights",
      "rectangle", "shadow_rays", "solid", "spot_lights", "texture"};
  return names;
}

std::vector<std::string> find_features(const Scene& scene) {
  std::set<std::string> used;
  auto use = [&](const char* name, bool yes = true) {
    if (yes) used.insert(name);
  };
  std::vector<bool> seen(scene.objects.size()), seen_material(scene.materials.size());
  std::vector<uint32_t> pending{scene.root};
  auto visit = [&](const Assembly& assembly) {
    use("hierarchy", assembly.accelerator.stats().kind != "none");
    for (const Instance& instance : assembly.instances) {
      pending.push_back(instance.object);
      if (instance.material != kInherit) seen_material[instance.material] = true;
    }
  };
  bool placed = false;
  while (!pending.empty()) {
    uint32_t handle = pending.back();
    pending.pop_back();
    if (seen[handle]) {
      use("instances");  // stored once, used more than once
      continue;
    }
    seen[handle] = true;
    const Object& object = scene.objects[handle];
    switch (object.kind) {
      case Kind::Solid: use("solid"), placed = true; break;
      case Kind::Flat:
        use(std::holds_alternative<Disk>(scene.flats[object.index]) ? "disk" : "rectangle"), placed = true;
        break;
      case Kind::Mesh:
        use("mesh"), placed = true;
        use("hierarchy", scene.meshes[object.index].accelerator().stats().kind != "none");
        break;
      case Kind::Csg: use("csg"), visit(scene.csgs[object.index].assembly); break;
      case Kind::Group: visit(scene.groups[object.index]); break;
    }
  }
  use("lens", scene.camera.has_lens());
  use("pixel_filter", scene.filter.kind() != PixelFilter::Kind::Box);
  use("shadow_rays", scene.integrator == Integrator::AmbientOcclusion);
  if (!traces_light(scene.integrator)) return {used.begin(), used.end()};  // geometry is all that it looks at
  bool any_material = false;
  for (size_t i = 0; i < scene.materials.size(); ++i) any_material |= seen_material[i];
  if (placed && !any_material) seen_material[0] = true;
  for (size_t i = scene.materials.size(); i-- > 0;) {  // a blend stands behind its parts
    if (!seen_material[i]) continue;
    const Material& m = scene.materials[i];
    for (int part = 0; part < Material::kMostParts; ++part)
      if (m.shares[part] > 0.0) seen_material[m.parts[part]] = true;
    const bool microfacets = m.kind == MaterialKind::Conductor || m.kind == MaterialKind::Dielectric ||
                             m.kind == MaterialKind::Plastic;
    use("diffuse", m.kind == MaterialKind::Diffuse);
    use("oren_nayar", m.kind == MaterialKind::Diffuse && m.roughness > 0.0);
    use("mirror", m.kind == MaterialKind::Mirror);
    use("conductor", m.kind == MaterialKind::Conductor);
    use("dielectric", m.refracts);
    use("dispersion", m.dispersion != 0.0 && (scene.integrator == Integrator::Path || scene.integrator == Integrator::Direct));
    use("plastic", m.kind == MaterialKind::Plastic);
    use("phong", m.kind == MaterialKind::Phong);
    use("blend", m.kind == MaterialKind::Blend);
    use("microfacets", microfacets && !m.smooth());
    use("absorption", m.refracts && max_component(m.absorption) > 0.0);
    use("opacity", m.opacity < 1.0);
    use("emission", m.emits());
    for (int texture : {m.texture, m.roughness_texture, m.opacity_texture, m.emission_texture, m.normal_map}) {
      use("texture", texture >= 0);
      use("image_texture", texture >= 0 && std::holds_alternative<ImageTexture>(scene.textures[texture]));
    }
    use("normal_map", m.normal_map >= 0);
  }
  use("background", max_component(scene.background) > 0.0);
  use("environment", scene.lights.environment != nullptr);
  use("point_lights", !scene.lights.points.empty());
  use("spot_lights", !scene.lights.spots.empty());
  use("directional_lights", !scene.lights.directionals.empty());
  use("area_lights", !scene.lights.areas.empty());
  use("light_tree", scene.next_event && scene.lights.has_tree());
  use("shadow_rays", scene.next_event && scene.lights.count() > 0);
  return {used.begin(), used.end()};
}

std::string kernel_name(const Scene& scene) {
  if (PlainScene::of(scene)) return std::string(name_of(scene.integrator)) + ", all objects, four paths at a time";
  return std::string(name_of(scene.integrator)) + ", " + scene.accelerator.kind + ", scalar";
}

}  // namespace tilecast
