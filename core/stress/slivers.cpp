// Gate 7: triangles of aspect up to 1e7.
#include "accel/accelerated_mesh.h"
#include "stress/meshes.h"
#include "stress/stress.h"

namespace tilecast::stress {
namespace {

constexpr double kFloatRoundoff = 0x1p-24;

// Triangles as long as the mesh, of aspect 1 .. 1e7.
const AcceleratedMesh& slivers() {
  static const AcceleratedMesh mesh = [] {
    Random random(7);
    MeshSource source;
    for (uint32_t i = 0; i < 48; ++i) {
      Vec3 along = random_direction(random), across = glm::normalize(glm::cross(along, random_direction(random)));
      double width = 1.0 / power_of_ten(random, 0.0, 7.0);
      Vec3 apex = (std::uniform_real_distribution<double>(-1, 1)(random)) * along + width * across;
      source.vertices.insert(source.vertices.end(), {-along, along, apex});
      source.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return AcceleratedMesh(source.build(), "auto");
  }();
  return mesh;
}

// How far p lies from the triangle: the least of the distances from its edges and, above it, from its plane. In double,
// whose roundoff is 2^-29 of the gate's.
double distance(const Vec3& p, const Vec3 corners[3]) {
  double least = std::numeric_limits<double>::infinity();
  Vec3 n = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
  bool above = true;
  for (int i = 0; i < 3; ++i) {
    Vec3 a = corners[i], e = corners[(i + 1) % 3] - a;
    double w = std::clamp(glm::dot(p - a, e) / glm::dot(e, e), 0.0, 1.0);
    least = std::min(least, glm::length(p - (a + w * e)));
    above = above && glm::dot(glm::cross(n, e), p - a) >= 0.0;
  }
  return above ? std::min(least, std::abs(glm::dot(n, p - corners[0])) / glm::length(n)) : least;
}

// The worst distance of a hit from its triangle, over the triangle's extent, in units of 8 u of float.
double point_error(Random& random, uint64_t i) {
  const AcceleratedMesh& mesh = slivers();
  std::uniform_real_distribution<double> unit(0, 1);
  auto corner = [&](uint32_t face, int k) {
    return mesh.mesh().frame.from_frame(Vec3(mesh.mesh().vertices[mesh.mesh().faces[face][k]]));
  };
  uint32_t target = random() % mesh.mesh().faces.size();
  double u = unit(random), v = unit(random) * (1.0 - u);
  Vec3 a = corner(target, 0), b = corner(target, 1), c = corner(target, 2);
  Vec3 p = a + u * (b - a) + v * (c - a);
  Vec3 from = random_direction(random);
  if (i & 1)  // along the triangle's plane, but for 1 .. 1e-7
    from = glm::normalize(glm::normalize(b - a) + from / power_of_ten(random, 0.0, 7.0));
  Ray ray{p + 3.0 * unit(random) * from, -from, -kInfinity};
  double worst = 0.0;
  for (const FaceHit& hit : mesh.all_hits(ray)) {
    Vec3 corners[3];
    double extent = 0.0;
    for (int k = 0; k < 3; ++k) corners[k] = corner(hit.face, k);
    for (int k = 0; k < 3; ++k) extent = std::max(extent, glm::length(corners[(k + 1) % 3] - corners[k]));
    Vec3 at = ray.origin + hit.t * ray.direction;
    double error = distance(at, corners) / (8 * kFloatRoundoff * extent);
    if (!(error <= worst)) worst = error;
  }
  return worst;
}

}  // namespace

void add_slivers(std::vector<Case>& out) {
  out.push_back({"slivers", 7, "distance of a hit from its triangle, in 8 u of the extent", 1, Combine::Max, 1'000'000,
                 1'000'000'000, worst_of(point_error)});
}

}  // namespace tilecast::stress
