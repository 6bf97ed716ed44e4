// Materials and textures as plain data.
#pragma once

#include "base/vec.h"

namespace tilecast {

enum class MaterialKind : uint8_t { Diffuse, Mirror, Conductor, Dielectric };

struct Material {
  MaterialKind kind = MaterialKind::Diffuse;
  Rgb reflectance{0.8};
  int texture = -1;         // replaces the reflectance
  double roughness = 0.0;   // conductor: GGX alpha = roughness^2; 0: smooth
  double ior = 1.5;         // dielectric: index of refraction inside over outside
  Rgb absorption{0.0};      // dielectric: per metre
  Rgb emission{0.0};        // radiance, leaves the side that the geometric normal points to

  bool emits() const { return max_component(emission) > 0.0; }
};

// Cells of `size` metres in object space, in turn `even` and `odd`.
struct Checker {
  Rgb even{0.9}, odd{0.1};
  double size = 1.0;

  // `p` must lie off the cell's walls: callers step from the surface towards its inside first.
  Rgb at(const Vec3& p) const {
    Vec3 cell = glm::floor(p / size);
    double parity = cell.x + cell.y + cell.z;
    return parity - 2.0 * std::floor(0.5 * parity) == 0.0 ? even : odd;
  }
};

}  // namespace tilecast
