// The immutable scene.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "base/sampler.h"
#include "optics/energy.h"
#include "scene/camera.h"
#include "scene/light.h"
#include "scene/material.h"
#include "scene/object.h"
#include "scene/pixel_filter.h"
#include "scene/texture.h"

namespace tilecast {

// Path, Direct and Whitted trace light; ambient occlusion looks at geometry alone, and so do the others: views, which
// show what a camera ray meets.
enum class Integrator : uint8_t {
  Path, Direct, Whitted, AmbientOcclusion, Normals, Depth, Primitives, Instances, Facing, Cost
};
inline constexpr const char* kIntegratorNames[]{"path",  "direct",     "whitted",   "ambient-occlusion", "normals",
                                                "depth", "primitives", "instances", "facing",            "cost"};

inline const char* name_of(Integrator integrator) { return kIntegratorNames[static_cast<int>(integrator)]; }
inline bool is_view(Integrator integrator) { return integrator > Integrator::AmbientOcclusion; }
inline bool traces_light(Integrator integrator) { return integrator <= Integrator::Whitted; }

using FaceUvs = std::array<glm::vec2, 3>;  // texture coordinates of a triangle's corners

struct Scene {
  std::vector<Object> objects;
  std::vector<Solid> solids;
  std::vector<Flat> flats;
  std::vector<AcceleratedMesh> meshes;
  std::vector<std::vector<FaceUvs>> mesh_uvs;  // of each mesh, by face; empty: it needs none
  std::vector<Csg> csgs;
  std::vector<Assembly> groups;
  uint32_t root = 0;  // index of an object

  std::vector<Material> materials;  // materials[0] is the default
  std::vector<Texture> textures;
  std::vector<EnergyTable> conductor_losses;         // of rough conductors, by Material::energy
  std::vector<CoatEnergy> coat_energies;             // of plastics
  std::vector<DielectricEnergy> dielectric_energies;  // of rough dielectrics, each with a medium beside it:
  std::vector<int> pairs;                            // index of its energy, by Material::energy + Material::medium
  std::vector<int> roughness_levels;  // of textured roughness: indices of tables, by Material::energy + level
  Lights lights;
  Rgb background{0.0};
  Camera camera;
  PixelFilter filter;

  Integrator integrator = Integrator::Path;
  int max_depth = 8;       // path segments from the camera
  double ao_distance = kInfinity;  // how far ambient occlusion looks, metres
  uint32_t seed = 0;
  Sampling sampling = Sampling::Sobol;
  bool next_event = true;  // sample the lights
  bool roulette = true;    // end paths that carry little
  double contrast = 0.0;   // above which neighbouring pixels get all of their samples; 0: all get them

  bool dielectrics = false;           // a material refracts
  bool disperses = false;             // one of them by wavelength
  bool see_through = false;           // a material has an opacity below 1
  std::vector<std::string> features;  // what the scene uses, of all_features()
  AcceleratorStats accelerator;       // all levels together
};

// Everything that a scene can use or leave out.
const std::vector<std::string>& all_features();
std::vector<std::string> find_features(const Scene& scene);

// The code that traces the scene: integrator, accelerator, vector width.
std::string kernel_name(const Scene& scene);

}  // namespace tilecast
