// Triangle meshes to trace: read from a PLY file, or made.
#pragma once

#include <string>
#include <vector>

#include "base/vec.h"

namespace tilecast::bench {

struct Triangles {
  std::string name;
  std::vector<Vec3> vertices;  // whole floats: every tracer gets the same triangles
  std::vector<glm::uvec3> faces;
};

// Binary little-endian, float positions alone, faces of three: as trimesh writes them.
Triangles read_ply(const std::string& path);
// Two triangles for each of side x side squares; heights of seven octaves of value noise.
Triangles terrain(uint32_t side);
// Triangles of a hundredth of the cube that they fill, anywhere in it.
Triangles soup(uint32_t count);

}  // namespace tilecast::bench
