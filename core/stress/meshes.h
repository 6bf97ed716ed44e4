// Closed meshes made on the spot.
#pragma once

#include <map>
#include <vector>

#include "geometry/mesh.h"
#include "stress/random.h"

namespace tilecast::stress {

struct MeshSource {
  std::vector<Vec3> vertices;
  std::vector<glm::uvec3> faces;

  Mesh build() const { return Mesh::build(vertices, faces); }
  MeshSource transformed(double scale, const Vec3& offset) const {
    MeshSource out = *this;
    for (Vec3& v : out.vertices) v = v * scale + offset;
    return out;
  }
};

// An icosahedron whose faces are split in four, `levels` times, vertices on the unit sphere.
inline MeshSource icosphere(int levels) {
  const double g = 0.5 * (1.0 + std::sqrt(5.0));
  MeshSource m;
  m.vertices = {{-1, g, 0}, {1, g, 0}, {-1, -g, 0}, {1, -g, 0}, {0, -1, g}, {0, 1, g},
                {0, -1, -g}, {0, 1, -g}, {g, 0, -1}, {g, 0, 1}, {-g, 0, -1}, {-g, 0, 1}};
  m.faces = {{0, 11, 5}, {0, 5, 1}, {0, 1, 7}, {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
             {3, 9, 4}, {3, 4, 2}, {3, 2, 6}, {3, 6, 8}, {3, 8, 9}, {4, 9, 5}, {2, 4, 11}, {6, 2, 10}, {8, 6, 7}, {9, 8, 1}};
  for (Vec3& v : m.vertices) v = glm::normalize(v);
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
    auto middle = [&](uint32_t a, uint32_t b) {
      auto [it, fresh] = middles.try_emplace(std::minmax(a, b), static_cast<uint32_t>(m.vertices.size()));
      if (fresh) m.vertices.push_back(glm::normalize(m.vertices[a] + m.vertices[b]));
      return it->second;
    };
    std::vector<glm::uvec3> faces;
    for (const glm::uvec3& f : m.faces) {
      uint32_t ab = middle(f.x, f.y), bc = middle(f.y, f.z), ca = middle(f.z, f.x);
      faces.insert(faces.end(), {{f.x, ab, ca}, {f.y, bc, ab}, {f.z, ca, bc}, {ab, bc, ca}});
    }
    m.faces = faces;
  }
  return m;
}

// A cube of half-size 1 whose sides are grids of n x n squares, with flat faces and axis-aligned edges.
inline MeshSource gridded_cube(int n) {
  MeshSource m;
  std::map<std::array<int, 3>, uint32_t> index;
  auto vertex = [&](std::array<int, 3> key) {
    auto [it, fresh] = index.try_emplace(key, static_cast<uint32_t>(m.vertices.size()));
    if (fresh) m.vertices.push_back({2.0 * key[0] / n - 1.0, 2.0 * key[1] / n - 1.0, 2.0 * key[2] / n - 1.0});
    return it->second;
  };
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side)
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          auto corner = [&](int a, int b) {
            std::array<int, 3> key{};
            key[axis] = side * n, key[(axis + 1) % 3] = i + a, key[(axis + 2) % 3] = j + b;
            return vertex(key);
          };
          uint32_t p = corner(0, 0), q = corner(1, 0), r = corner(1, 1), s = corner(0, 1);
          if (!side) std::swap(q, s);
          m.faces.push_back({p, q, r});
          m.faces.push_back({p, r, s});
        }
  return m;
}

inline MeshSource torus(double major, double minor, int n, int k) {
  MeshSource m;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < k; ++j) {
      double a = 2 * kPi * i / n, b = 2 * kPi * j / k, r = major + minor * std::cos(b);
      m.vertices.push_back({r * std::cos(a), minor * std::sin(b), r * std::sin(a)});
    }
  auto at = [&](int i, int j) { return static_cast<uint32_t>((i % n) * k + j % k); };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < k; ++j) {
      m.faces.push_back({at(i, j), at(i, j + 1), at(i + 1, j + 1)});
      m.faces.push_back({at(i, j), at(i + 1, j + 1), at(i + 1, j)});
    }
  return m;
}

// Every tenth face split in two at the middle of its first edge, with a third face, collinear, between the halves and
// the neighbour; and as many faces again with a repeated vertex.
inline MeshSource with_collinear_faces(const MeshSource& source) {
  MeshSource m{source.vertices, {}};
  for (size_t i = 0; i < source.faces.size(); ++i) {
    glm::uvec3 f = source.faces[i];
    if (i % 10 != 0) {
      m.faces.push_back(f);
      continue;
    }
    uint32_t middle = static_cast<uint32_t>(m.vertices.size());
    m.vertices.push_back(0.5 * (m.vertices[f.x] + m.vertices[f.y]));
    m.faces.insert(m.faces.end(), {{f.x, middle, f.z}, {middle, f.y, f.z}, {f.x, f.y, middle}, {f.x, f.y, f.x}});
  }
  return m;
}

// Uniform over the unit sphere: of a cube's points those within the ball.
inline Vec3 random_direction(Random& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  for (;;) {
    Vec3 v{unit(random), unit(random), unit(random)};
    double length2 = glm::dot(v, v);
    if (length2 > 1e-4 && length2 <= 1.0) return v / std::sqrt(length2);
  }
}

// A point of the mesh where tracers leak: a vertex, or a point on an edge.
inline Vec3 vertex_or_edge_point(const Mesh& mesh, size_t face, Random& random) {
  const glm::uvec3& f = mesh.faces[face];
  int k = random() % 3;
  Vec3 a = mesh.frame.from_frame(Vec3(mesh.vertices[f[k]])), b = mesh.frame.from_frame(Vec3(mesh.vertices[f[(k + 1) % 3]]));
  if (random() & 1) return a;
  double w = (random() & 1) ? 0.5 : std::uniform_real_distribution<double>(0, 1)(random);
  return a + w * (b - a);
}
inline Vec3 vertex_or_edge_point(const Mesh& mesh, Random& random) {
  return vertex_or_edge_point(mesh, random() % mesh.faces.size(), random);
}

}  // namespace tilecast::stress
