// A triangle mesh: float vertices about the mesh's own centre (base/frame.h).
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/triangle.h"

namespace tilecast {

struct Mesh {
  Frame frame;
  std::vector<Vec3f> vertices;     // frame coordinates
  std::vector<glm::uvec3> faces;   // counter-clockwise seen from outside
  Box bounds;                      // of the faces' rounded vertices, in the mesh's own space, metres
  uint64_t dropped = 0;            // faces with a repeated vertex; they stay in `faces`, and nothing can hit them

  // vertices: metres, mesh space; faces: indices into them. Refuses values that are not finite or beyond 1e100, and
  // indices out of range. Collinear faces stay: dropping them would open the mesh.
  static Mesh build(std::span<const Vec3> vertices, std::span<const glm::uvec3> faces);

  bool repeats_vertex(const glm::uvec3& f) const { return f.x == f.y || f.y == f.z || f.z == f.x; }
  Triangle triangle(uint32_t face) const {
    const glm::uvec3& f = faces[face];
    return {vertices[f.x], vertices[f.y], vertices[f.z]};
  }
};

// What keeps the mesh from being closed: an edge that is not run through as often in one direction as in the other,
// or nothing. Vertices at the same place count as one.
std::optional<std::string> find_open_edge(const Mesh& mesh);

// Negative where the faces are turned inside out. In units of the frame, cubed.
double signed_volume(const Mesh& mesh);

}  // namespace tilecast
