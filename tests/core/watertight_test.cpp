// Rays aimed at the vertices and edges of closed meshes: none escapes, and crossings along the whole line are even with
// signs that sum to zero (hazards: Woop et al. 2013 with exact signs and a symbolic tie-break).
#include <gtest/gtest.h>

#include "accel/accelerated_mesh.h"
#include "stress/meshes.h"

namespace tilecast {
namespace {

using stress::MeshSource;

// 3 meshes x 6 parameters x 112,000 rays: 1e6 from inside and as many from afar.
#ifdef __SANITIZE_ADDRESS__
constexpr int kRays = 4000;
#else
constexpr int kRays = 112000;
#endif

struct Tally {
  int escaped = 0, odd = 0, unbalanced = 0;
};

// `rays` rays, half from a random point inside, half from far away.
Tally aim(const MeshSource& source, const Vec3& inside, double inside_radius, double scale, double offset_radii, int rays,
          uint64_t seed) {
  std::mt19937_64 random(seed);
  Vec3 offset = offset_radii * scale * stress::random_direction(random);
  AcceleratedMesh mesh(source.transformed(scale, offset).build(), "bvh");
  Tally tally;
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < rays; ++i) {
    Vec3 target = stress::vertex_or_edge_point(mesh.mesh(), random);
    Vec3 start = offset + scale * (inside + inside_radius * unit(random) * stress::random_direction(random));
    if (i % 2) start = offset + scale * 100.0 * stress::random_direction(random);
    Ray ray{start, target - start};
    if (i % 4 < 2) ray.direction = glm::normalize(ray.direction);
    int count = 0, sum = 0;
    bool hit = false;
    mesh.intersect(ray, -kInfinity, kInfinity, [&](uint32_t, const TriangleHit& h) {
      ++count;
      sum += h.entering ? 1 : -1;
      hit |= h.t > 0.0;
      return false;
    });
    if (i % 2 == 0 && !hit) ++tally.escaped;
    tally.odd += count % 2;
    tally.unbalanced += sum != 0;
  }
  return tally;
}

class Watertight : public ::testing::TestWithParam<std::tuple<double, double>> {};

TEST_P(Watertight, NoRayLeavesAClosedMeshAndCrossingsAreEven) {
  auto [scale, offset] = GetParam();
  struct Case {
    MeshSource mesh;
    Vec3 inside;
    double radius;
  } cases[] = {{stress::icosphere(3), Vec3(0.0), 0.9},
               {stress::gridded_cube(6), Vec3(0.0), 0.9},
               {stress::torus(1.0, 0.4, 30, 20), Vec3(1.0, 0.0, 0.0), 0.3}};
  uint64_t seed = 1;
  for (const Case& c : cases) {
    Tally tally = aim(c.mesh, c.inside, c.radius, scale, offset, kRays, seed++);
    EXPECT_EQ(tally.escaped, 0);
    EXPECT_EQ(tally.odd, 0);
    EXPECT_EQ(tally.unbalanced, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Scales, Watertight,
                         ::testing::Combine(::testing::Values(1e-6, 1.0, 1e6), ::testing::Values(0.0, 1e6)));

TEST(Watertight, CollinearFacesDoNotOpenAMesh) {
  // Every edge of the cube's first side gets a face of zero area: T-junctions with a collinear filler.
  MeshSource source = stress::gridded_cube(4);
  std::vector<glm::uvec3> faces;
  for (size_t i = 0; i < source.faces.size(); ++i) {
    glm::uvec3 f = source.faces[i];
    if (i % 10 != 0) {
      faces.push_back(f);
      continue;
    }
    // f becomes two faces through the middle of its first edge, and the edge keeps a collinear face beside it.
    uint32_t m = static_cast<uint32_t>(source.vertices.size());
    source.vertices.push_back(0.5 * (source.vertices[f.x] + source.vertices[f.y]));
    faces.insert(faces.end(), {{f.x, m, f.z}, {m, f.y, f.z}, {f.x, f.y, m}});
  }
  source.faces = faces;
  ASSERT_FALSE(find_open_edge(source.build()).has_value());
  Tally tally = aim(source, Vec3(0.0), 0.9, 1.0, 0.0, 100000, 9);
  EXPECT_EQ(tally.escaped + tally.odd + tally.unbalanced, 0);
}

TEST(Watertight, AxisAlignedRaysOnTheEdgesOfAGrid) {
  AcceleratedMesh mesh(stress::gridded_cube(8).build(), "bvh");
  for (int axis = 0; axis < 3; ++axis)
    for (int sign = -1; sign <= 1; sign += 2)
      for (double zero : {0.0, -0.0})
        for (int i = 1; i < 8; ++i)
          for (int j = 1; j < 8; ++j) {
            Vec3 origin(0.0), direction(zero);
            origin[(axis + 1) % 3] = i / 4.0 - 1.0;
            origin[(axis + 2) % 3] = j / 4.0 - 1.0;
            direction[axis] = sign;
            int count = 0;
            mesh.intersect({origin, direction}, 0.0, kInfinity, [&](uint32_t, const TriangleHit& hit) {
              EXPECT_EQ(hit.t, 1.0);
              EXPECT_FALSE(hit.entering);
              ++count;
              return false;
            });
            EXPECT_EQ(count, 1);
          }
}

TEST(OpenEdge, IsNamed) {
  MeshSource source = stress::icosphere(1);
  EXPECT_FALSE(find_open_edge(source.build()).has_value());
  source.faces.pop_back();
  auto edge = find_open_edge(source.build());
  ASSERT_TRUE(edge.has_value());
  EXPECT_NE(edge->find("the edge between vertices"), std::string::npos);
}

}  // namespace
}  // namespace tilecast
