// What textures mean for the materials that name them, and for the meshes that those are put on.
#include "base/check.h"
#include "optics/energy_between.h"
#include "scene/builder.h"

namespace tilecast {
namespace {

// The values of a parameter's texture, in all channels or in the first, must be those that the parameter may have.
void check_range(const Texture& texture, bool all_channels, const char* name, double greatest) {
  const Rgb low = least(texture), high = most(texture);
  for (int i = 0; i < (all_channels ? 3 : 1); ++i)
    if (!(low[i] >= 0.0 && high[i] <= greatest))
      throw Error(std::string(name) + ": must lie between 0 and " + text(greatest) + ", but the texture's values go from " +
                  text(low[i]) + " to " + text(high[i]));
}

}  // namespace

int SceneBuilder::add_texture(const Texture& texture) {
  check(texture);
  scene_.textures.push_back(texture);
  return static_cast<int>(scene_.textures.size() - 1);
}

void SceneBuilder::apply_textures(Material& m) const {
  for (int texture : {m.texture, m.roughness_texture, m.opacity_texture, m.emission_texture, m.normal_map}) {
    if (texture >= static_cast<int>(scene_.textures.size()) || texture < -1) throw Error("texture: no such texture");
    if (texture < 0) continue;
    m.textured = true;
    m.uses_uv |= needs_uv(scene_.textures[texture]) || texture == m.normal_map;
  }
  if (m.texture >= 0) check_range(scene_.textures[m.texture], true, "reflectance", 1.0);
  if (m.opacity_texture >= 0) {
    check_range(scene_.textures[m.opacity_texture], false, "opacity", 1.0);
    m.opacity = least(scene_.textures[m.opacity_texture]).x;
  }
  if (m.emission_texture >= 0) {
    check_range(scene_.textures[m.emission_texture], true, "emission", 1e30);
    m.emission = most(scene_.textures[m.emission_texture]);
  }
  if (m.roughness_texture >= 0) {
    if (m.kind == MaterialKind::Dielectric)
      throw Error("roughness: a dielectric takes a number; a texture would need too many tables of its energy");
    check_range(scene_.textures[m.roughness_texture], false, "roughness", 1.0);
    m.roughness = most(scene_.textures[m.roughness_texture]).x;
    m.first_level = static_cast<int>(least(scene_.textures[m.roughness_texture]).x * kRoughnessLevels);
    if (m.smooth()) m.roughness_texture = -1;  // all of it
  }
}

std::vector<bool> SceneBuilder::meshes_with_uvs(uint32_t root) const {
  struct Visit {
    uint32_t object;
    bool asked;  // by the material of an enclosing instance
  };
  std::vector<bool> needed(scene_.meshes.size());
  std::vector<uint8_t> seen(scene_.objects.size());  // one bit for each way to come
  std::vector<Visit> pending{{root, false}};
  while (!pending.empty()) {
    const auto [handle, asked] = pending.back();
    pending.pop_back();
    if (seen[handle] & (asked ? 2 : 1)) continue;
    seen[handle] |= asked ? 2 : 1;
    const Object& object = scene_.objects[handle];
    if (object.kind == Kind::Mesh && asked) needed[object.index] = true;
    const std::vector<Instance>* inner = object.kind == Kind::Group ? &scene_.groups[object.index].instances
                                         : object.kind == Kind::Csg ? &csg_sources_[object.index].operands
                                                                    : nullptr;
    if (!inner) continue;
    for (const Instance& instance : *inner)
      pending.push_back({instance.object, instance.material == kInherit ? asked : scene_.materials[instance.material].uses_uv});
  }
  return needed;
}

std::vector<uint32_t> SceneBuilder::without_uvs(uint32_t root) const {
  if (root >= scene_.objects.size()) throw Error("root: no such object");
  const std::vector<bool> needed = meshes_with_uvs(root);
  std::vector<uint32_t> out;
  for (uint32_t handle = 0; handle < scene_.objects.size(); ++handle)
    if (const Object& object = scene_.objects[handle];
        object.kind == Kind::Mesh && needed[object.index] && scene_.mesh_uvs[object.index].empty())
      out.push_back(handle);
  return out;
}

void SceneBuilder::drop_unused_uvs(uint32_t root) {
  const std::vector<bool> needed = meshes_with_uvs(root);
  for (size_t i = 0; i < needed.size(); ++i)
    if (!needed[i]) scene_.mesh_uvs[i] = {};
}

}  // namespace tilecast
