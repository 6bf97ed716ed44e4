// Builds a Scene, object by object. Handles are indices; every call checks what it is given and throws Error.
#pragma once

#include <memory>

#include "scene/scene.h"

namespace tilecast {

struct InstanceSource {
  uint32_t object;
  Affine transform;
  int material = kInherit;
};

class SceneBuilder {
 public:
  SceneBuilder();

  uint32_t add_solid(const Solid& solid);
  uint32_t add_flat(const Flat& flat);
  uint32_t add_rectangle(double width, double depth) { return add_flat(Rectangle{width, depth}); }
  // uvs: of each face's corners; empty: none.
  uint32_t add_mesh(Mesh mesh, const AcceleratorChoice& choice, std::vector<FaceUvs> uvs = {});
  // At least two closed operands; a difference takes all the others from the first.
  uint32_t add_csg(CsgOperation operation, const std::vector<InstanceSource>& operands);
  uint32_t add_group(const std::vector<InstanceSource>& instances, const AcceleratorChoice& choice);

  int add_material(const Material& material);
  int add_texture(const Texture& texture);
  void add_point_light(const PointLight& light);
  void add_spot_light(const SpotLight& light);
  void add_directional_light(const DirectionalLight& light);
  void set_background(const Rgb& radiance);
  // Instead of a background; of an image that is black all over nothing is kept.
  void set_environment(Environment environment);
  void set_camera(const Camera& camera) { scene_.camera = camera; }
  void set_filter(PixelFilter::Kind kind) { scene_.filter = PixelFilter(kind); }

  // The meshes under an object without texture coordinates, although a material that is put on them asks for some.
  std::vector<uint32_t> without_uvs(uint32_t root) const;

  struct Options {
    Integrator integrator = Integrator::Path;
    int max_depth = 8;
    uint32_t seed = 0;
    bool next_event = true;
    double ao_distance = kInfinity;
    Sampling sampling = Sampling::Sobol;
    bool roulette = true;
    double contrast = 0.0;
  };
  // Finishes the scene; the builder is empty afterwards.
  std::shared_ptr<const Scene> build(uint32_t root, const Options& options);

 private:
  struct CsgSource {
    CsgOperation operation;
    std::vector<Instance> operands;
  };
  struct Facts {  // of an object, beside Object
    bool checked_open = false;
    std::string open;               // why it is not closed; empty: it is
    int depth = 0;                  // of nested groups
    bool has_emitter = false;       // an instance inside emits
    bool inherits = true;           // a part of it takes the material of the enclosing instance
  };

  uint32_t add(Kind kind, size_t index, uint64_t primitives, const Box& bounds);
  std::vector<Instance> place(const std::vector<InstanceSource>& sources, const char* list) const;
  void note_instances(uint32_t object, const std::vector<Instance>& instances);
  const std::string& why_open(uint32_t object);
  Csg flatten(const CsgSource& source, const Box& bounds);
  uint32_t cut_off(uint32_t solid, const Box& bounds);
  void blend(Material& material) const;
  void apply_textures(Material& material) const;
  std::vector<bool> meshes_with_uvs(uint32_t root) const;
  void drop_unused_uvs(uint32_t root);
  void finish_materials();
  void finish_reachable();
  double expected_cost(uint32_t object) const;
  void collect_lights(uint32_t object, const Affine& to_world, int material, uint64_t base);

  Scene scene_;
  std::vector<CsgSource> csg_sources_;
  std::vector<Facts> facts_;
  size_t light_pieces_ = 0;  // that collect_lights() has met
};

}  // namespace tilecast
