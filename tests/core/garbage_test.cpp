// Whatever comes in, nothing crashes, and no hit has a t that is not a number.
#include <gtest/gtest.h>

#include "scene/surface.h"
#include "stress/scenes.h"

namespace tilecast {
namespace {

using namespace stress;

const double kOddities[] = {0.0,   -0.0,   1.0,  -1.0,   0.25,   1e-320, -1e-320, 1e-160, 1e160,
                            1e308, -1e308, 1e18, 1e-18, kInfinity, -kInfinity, std::nan("")};

TEST(Garbage, RaysOfAnyKindAreAnswered) {
  SceneBuilder builder;
  uint32_t sphere = builder.add_solid(Sphere{0.5}), block = builder.add_solid(Block{Vec3(-0.4), Vec3(0.4)});
  uint32_t cylinder = builder.add_solid(Cylinder{0.3, 1.0}), rectangle = builder.add_rectangle(1, 1);
  uint32_t mesh = builder.add_mesh(icosphere(1).build(), "bvh");
  uint32_t csg = builder.add_csg(CsgOperation::Difference, {{block, Affine{}}, {mesh, translate(Vec3(0.5))}, {sphere, Affine{}}});
  auto scene = scene_of(builder,
                        {{sphere, translate(Vec3(1))}, {cylinder, Affine{}}, {rectangle, Affine{}}, {mesh, scale(Vec3(1e-80))},
                         {mesh, scale(Vec3(-3, 1, 1))}, {csg, rotate(1.0, Vec3(0, 1, 0))}},
                        "bvh");
  Random random(1);
  auto odd = [&] { return kOddities[random() % std::size(kOddities)]; };
  std::vector<Crossing> list;
  for (int i = 0; i < 100000; ++i) {
    Ray ray{{odd(), odd(), odd()}, {odd(), odd(), odd()}, odd(), odd()};
    Hit hit = closest(*scene, ray);
    if (hit.found()) {
      ASSERT_FALSE(std::isnan(hit.t));
      resolve(*scene, ray, hit);
    }
    occluded(*scene, ray);
    crossings(*scene, ray, list);
  }
}

TEST(Garbage, MeshesAreRefusedOrBuilt) {
  Random random(2);
  auto odd = [&] { return kOddities[random() % std::size(kOddities)]; };
  int built = 0;
  for (int i = 0; i < 20000; ++i) {
    std::vector<Vec3> vertices;
    bool finite = true;
    for (int k = 0; k < 4; ++k) {
      vertices.push_back({odd(), i % 2 ? 0.5 : odd(), i % 3 ? -0.25 : odd()});
      if (i % 5 == 0) vertices.back().x = k;
      finite = finite && is_finite(vertices.back());
    }
    std::vector<glm::uvec3> faces{{0, 1, 2}, {2, 1, 3}, {0, 0, 1}, {0, 2, random() % 9 ? 3u : 4u}};
    try {
      AcceleratedMesh mesh(Mesh::build(vertices, faces), "bvh");
      ASSERT_TRUE(finite);
      ++built;
      for (const FaceHit& hit : mesh.all_hits({{0, 0, 5}, {0.01, 0.02, -1}})) EXPECT_FALSE(std::isnan(hit.t));
      find_open_edge(mesh.mesh());
    } catch (const Error&) {
    }
  }
  EXPECT_GT(built, 100);
}

}  // namespace
}  // namespace tilecast
