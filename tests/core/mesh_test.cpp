#include <gtest/gtest.h>

#include "accel/accelerated_mesh.h"
#include "stress/meshes.h"

namespace tilecast {
namespace {

using stress::MeshSource;

TEST(Mesh, IsHitOnceByAxisAlignedRaysOnTheEdgesOfAGrid) {
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
            std::vector<FaceHit> hits = mesh.all_hits({origin, direction});
            ASSERT_EQ(hits.size(), 1u);
            EXPECT_EQ(hits[0].t, 1.0);
            EXPECT_FALSE(hits[0].entering);
          }
}

TEST(Mesh, NamesAnOpenEdge) {
  MeshSource source = stress::icosphere(1);
  EXPECT_FALSE(find_open_edge(source.build()).has_value());
  source.faces.pop_back();
  auto edge = find_open_edge(source.build());
  ASSERT_TRUE(edge.has_value());
  EXPECT_NE(edge->find("the edge between vertices"), std::string::npos);
}

}  // namespace
}  // namespace tilecast
