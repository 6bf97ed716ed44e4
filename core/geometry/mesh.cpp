#include "geometry/mesh.h"

#include <map>
#include <unordered_map>

#include "base/error.h"

namespace tilecast {
namespace {

constexpr double kLargest = 1e100;

struct PlaceHash {
  size_t operator()(const Vec3f& v) const {
    uint64_t h = 0;
    for (int i = 0; i < 3; ++i) h = (h ^ __builtin_bit_cast(uint32_t, v[i] + 0.0f)) * 0x9e3779b97f4a7c15ull;
    return h ^ (h >> 29);
  }
};

// For each vertex the first one at the same place.
std::vector<uint32_t> weld(const std::vector<Vec3f>& vertices) {
  std::unordered_map<Vec3f, uint32_t, PlaceHash> places;
  places.reserve(vertices.size());
  std::vector<uint32_t> first(vertices.size());
  for (uint32_t i = 0; i < vertices.size(); ++i) first[i] = places.try_emplace(vertices[i], i).first->second;
  return first;
}

std::string place(const Mesh& mesh, uint32_t vertex) {
  Vec3 p = mesh.frame.from_frame(Vec3(mesh.vertices[vertex]));
  char text[120];
  std::snprintf(text, sizeof text, "(%.6g, %.6g, %.6g)", p.x, p.y, p.z);
  return text;
}

}  // namespace

Mesh Mesh::build(std::span<const Vec3> vertices, std::span<const glm::uvec3> faces) {
  Box box;
  for (size_t i = 0; i < vertices.size(); ++i) {
    if (!(max_abs(vertices[i]) <= kLargest) || !is_finite(vertices[i]))
      throw Error("vertices[" + std::to_string(i) + "] must be finite and at most 1e100 in size");
    box.extend(vertices[i]);
  }
  Mesh mesh;
  mesh.frame = Frame::around(box);
  mesh.vertices.reserve(vertices.size());
  for (const Vec3& v : vertices) {
    Vec3 p = mesh.frame.to_frame(v);
    mesh.vertices.emplace_back(to_grid(p.x), to_grid(p.y), to_grid(p.z));
  }
  for (size_t i = 0; i < faces.size(); ++i) {
    const glm::uvec3& f = faces[i];
    for (int k = 0; k < 3; ++k)
      if (f[k] >= vertices.size())
        throw Error("faces[" + std::to_string(i) + "] names vertex " + std::to_string(f[k]) + ", but there are " +
                    std::to_string(vertices.size()));
    if (mesh.repeats_vertex(f)) {
      ++mesh.dropped;
      continue;
    }
    for (int k = 0; k < 3; ++k) mesh.bounds.extend(mesh.frame.from_frame(Vec3(mesh.vertices[f[k]])));
  }
  mesh.faces.assign(faces.begin(), faces.end());
  return mesh;
}

std::optional<std::string> find_open_edge(const Mesh& mesh) {
  if (mesh.faces.size() == mesh.dropped) return "it has no faces";
  std::vector<uint32_t> first = weld(mesh.vertices);
  struct Edge {
    uint32_t low, high;
    int direction;
  };
  std::vector<Edge> edges;
  edges.reserve(3 * mesh.faces.size());
  for (const glm::uvec3& f : mesh.faces)
    for (int k = 0; k < 3; ++k) {
      uint32_t a = first[f[k]], b = first[f[(k + 1) % 3]];
      if (a != b) edges.push_back(a < b ? Edge{a, b, 1} : Edge{b, a, -1});
    }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
    return a.low != b.low ? a.low < b.low : a.high < b.high;
  });
  for (size_t i = 0; i < edges.size();) {
    size_t j = i;
    int sum = 0;
    for (; j < edges.size() && edges[j].low == edges[i].low && edges[j].high == edges[i].high; ++j)
      sum += edges[j].direction;
    if (sum != 0)
      return "the edge between vertices " + std::to_string(edges[i].low) + " " + place(mesh, edges[i].low) + " and " +
             std::to_string(edges[i].high) + " " + place(mesh, edges[i].high) + " is open";
    i = j;
  }
  return std::nullopt;
}

double signed_volume(const Mesh& mesh) {
  double sum = 0.0;
  for (uint32_t i = 0; i < mesh.faces.size(); ++i) {
    Triangle t = mesh.triangle(i);
    sum += glm::dot(Vec3(t.a), glm::cross(Vec3(t.b), Vec3(t.c)));
  }
  return sum / 6.0;
}

}  // namespace tilecast
