// Brute force is the oracle: t, primitive, u and v are the same, bit for bit.
#include <gtest/gtest.h>

#include <cstring>

#include "accel/wide_bvh.h"
#include "stress/scenes.h"

namespace tilecast {
namespace {

using namespace stress;

std::vector<AcceleratorChoice> choices() {
  std::vector<AcceleratorChoice> out{"auto"};
  for (const std::string& kind : accelerator_kinds()) out.push_back(std::string_view(kind));
  for (const std::string& grouping : grouping_names())
    for (bool reinsertion : {false, true}) {
      out.push_back("bvh");
      out.back().grouping = grouping;
      out.back().reinsertion = reinsertion;
    }
  return out;
}

#ifdef __SANITIZE_ADDRESS__
constexpr int kRays = 100;
#else
constexpr int kRays = 700;
#endif

TEST(Accelerators, GiveTheHitOfBruteForceBitForBit) {
  for (uint64_t seed = 1; seed <= 2; ++seed) {
    const Crowd size{.seed = seed, .cells = 4, .levels = 2, .copies = 3, .groups = 5};
    auto brute = crowd(size, "none");
    EXPECT_EQ(brute->accelerator.kind, "none");
    for (const AcceleratorChoice& choice : choices()) {
      auto scene = crowd(size, choice);
      SCOPED_TRACE(choice.kind + " " + choice.grouping);
      if (choice.kind != "auto") { EXPECT_EQ(scene->accelerator.kind, choice.kind); }
      Random random(seed);
      uint64_t occluder = 0;
      for (int i = 0; i < kRays; ++i) {
        Ray ray = random_ray(random, i % 2 ? 0.5 : 8.0);
        if (i % 7 == 0) ray.direction[i % 3] = i % 14 ? 0.0 : -0.0;
        Hit a = closest(*brute, ray), b = closest(*scene, ray);
        ASSERT_EQ(a.primitive, b.primitive);
        ASSERT_EQ(a.t, b.t);
        ASSERT_EQ(a.u, b.u);
        ASSERT_EQ(a.v, b.v);
        ray.t_max = 1.0;
        ASSERT_EQ(closest(*brute, ray).found(), occluded(*scene, ray));
        ASSERT_EQ(closest(*brute, ray).found(), occluded(*scene, ray, occluder));
        std::vector<Crossing> c, d;
        crossings(*brute, ray, c);
        crossings(*scene, ray, d);
        ASSERT_EQ(c.size(), d.size());
        for (size_t k = 0; k < c.size(); ++k) ASSERT_TRUE(c[k].same_as(d[k]));
      }
    }
  }
}

TEST(Accelerators, TellIdenticalPrimitivesApartByTheirOrder) {
  SceneBuilder builder;
  uint32_t sphere = builder.add_solid(Sphere{1.0});
  auto scene = scene_of(builder, std::vector<InstanceSource>(1000, {sphere, Affine{}}), "bvh");
  Hit hit = closest(*scene, {Vec3(0, 0, 5), Vec3(0, 0, -1)});
  EXPECT_EQ(hit.primitive, 0u);
  EXPECT_EQ(hit.t, 4.0);
}

// Eight boxes are met in one go: less needs nothing above it, and more does, however small a hierarchy looks by its cost.
TEST(Accelerators, OfItsOwnChoiceAddAHierarchyAboveEightObjects) {
  for (int count : {1, 8, 9, 20}) {
    SceneBuilder builder;
    uint32_t block = builder.add_solid(Block{Vec3(-0.5), Vec3(0.5)});
    std::vector<InstanceSource> row;
    for (int i = 0; i < count; ++i) row.push_back({block, translate(Vec3(i, 0, 0))});
    EXPECT_EQ(scene_of(builder, row, "auto")->accelerator.kind, count <= 8 ? "none" : "bvh") << count;
  }
}

TEST(Accelerators, BuildAMillionIdenticalTriangles) {
  MeshSource source{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, std::vector<glm::uvec3>(1000000, {0, 1, 2})};
  AcceleratedMesh mesh(source.build(), "bvh");
  EXPECT_LE(mesh.accelerator().stats().nodes, 2000000u);
  uint32_t first = ~0u;
  Ray ray{Vec3(0.2, 0.2, 1), Vec3(0, 0, -1)};
  for (const FaceHit& hit : mesh.all_hits(ray)) first = std::min(first, hit.face);
  EXPECT_EQ(first, 0u);
  NoCost free;
  EXPECT_EQ(mesh.closest(ray, free).face, 0u);
}

// Crowded, even, and in layers; one of a hundred is large.
Mesh mixed_triangles(uint32_t count, double large = 0.5) {
  Random random(5);
  std::vector<Vec3> vertices;
  std::vector<glm::uvec3> faces;
  auto place = [&] { return std::uniform_real_distribution<double>(-1, 1)(random); };
  for (uint32_t i = 0; i < count; ++i) {
    const double size = i % 100 ? 0.01 : large;
    const Vec3 at{std::pow(place(), 5), place(), std::floor(4 * place())};
    for (int k = 0; k < 3; ++k) vertices.push_back(at + size * Vec3(place(), place(), place()));
    faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return Mesh::build(vertices, faces);
}

std::vector<FrameBox> boxes_of(const Mesh& mesh) {
  std::vector<FrameBox> boxes;
  for (uint32_t i = 0; i < mesh.faces.size(); ++i) boxes.push_back(FrameBox::around(mesh.triangle(i)));
  return boxes;
}

template <class T>
bool same(const T& a, const T& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0;
}

TEST(Accelerators, BuildTheSameTreeOnAnyNumberOfThreads) {
  const Mesh mesh = mixed_triangles(60000);
  const std::vector<FrameBox> boxes = boxes_of(mesh);
  const PrimitiveSet primitives{boxes, 1.0f, &mesh};
  for (bool spatial : {false, true}) {
    auto build = [&](std::vector<uint32_t>& order, int threads) {
      return spatial ? Bvh::build_with_spatial_splits(primitives, 2 * boxes.size(), order, threads)
                     : Bvh::build(primitives, Grouping::Sah, order, threads);
    };
    std::vector<uint32_t> order, other_order;
    const Bvh bvh = build(order, 1);
    const WideBvh wide = WideBvh::fold(bvh, order, mesh);
    for (int threads : {2, 3, 8}) {
      const Bvh other = build(other_order, threads);
      EXPECT_TRUE(same(order, other_order));
      EXPECT_TRUE(same(bvh.nodes(), other.nodes()));
      const WideBvh other_wide = WideBvh::fold(other, other_order, mesh, threads);
      EXPECT_TRUE(same(wide.nodes(), other_wide.nodes()));
      EXPECT_TRUE(same(wide.blocks(), other_wide.blocks()));
    }
  }
}

TEST(Accelerators, PutEveryTriangleInOneBox) {
  const Mesh mesh = mixed_triangles(20000);
  const std::vector<FrameBox> boxes = boxes_of(mesh);
  std::vector<uint32_t> order;
  const Bvh bvh = Bvh::build({boxes, 1.0f, &mesh}, Grouping::Sah, order);
  const WideBvh wide = WideBvh::fold(bvh, order, mesh);
  std::vector<uint8_t> seen(boxes.size());
  for (const TriangleBlock& block : wide.blocks())
    for (uint32_t face : block.face)
      if (face != TriangleBlock::kNone) ++seen[face];
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<long>(boxes.size()));
  for (const Bvh::Node& node : bvh.nodes()) {
    FrameBox below;
    if (node.count > 0) {
      for (uint32_t i = 0; i < node.count; ++i) below.extend(boxes[order[node.first + i]]);
    } else {
      below = bvh.nodes()[node.first].box().joined(bvh.nodes()[node.first + 1].box());
    }
    for (int k = 0; k < 3; ++k) EXPECT_TRUE(node.lo[k] == below.lo[k] && node.hi[k] == below.hi[k]);
  }
}

TEST(Accelerators, CutWhatOverlapsAndNothingElse) {
  const Mesh smooth = icosphere(5).build();
  std::vector<FrameBox> boxes = boxes_of(smooth);
  std::vector<uint32_t> order;
  Bvh::build_with_spatial_splits({boxes, 1.0f, &smooth}, 3 * boxes.size(), order);
  EXPECT_EQ(order.size(), boxes.size());

  const Mesh mesh = mixed_triangles(20000, 2.0);
  boxes = boxes_of(mesh);
  const PrimitiveSet primitives{boxes, 1.0f, &mesh};
  const double whole = WideBvh::folded_cost(Bvh::build(primitives, Grouping::Sah, order));
  for (size_t most : {boxes.size() + 1, 3 * boxes.size() / 2, 3 * boxes.size()}) {
    const Bvh bvh = Bvh::build_with_spatial_splits(primitives, most, order);
    EXPECT_LE(order.size(), most);
    // Any point of a triangle lies in a leaf that has the triangle.
    std::vector<std::vector<FrameBox>> leaves(boxes.size());
    for (const Bvh::Node& node : bvh.nodes())
      for (uint32_t i = 0; i < node.count; ++i) leaves[order[node.first + i]].push_back(node.box());
    Random random(6);
    auto unit = [&] { return std::uniform_real_distribution<double>(0, 1)(random); };
    for (uint32_t face = 0; face < boxes.size(); ++face) {
      const Triangle t = mesh.triangle(face);
      for (int i = 0; i < 20; ++i) {
        const double s = std::sqrt(i < 10 ? 1.0 : unit()), v = unit();  // half of them on an edge
        const Vec3 p = (1 - s) * Vec3(t.a) + s * (1 - v) * Vec3(t.b) + s * v * Vec3(t.c);
        ASSERT_TRUE(std::any_of(leaves[face].begin(), leaves[face].end(), [&](const FrameBox& box) {
          return p.x >= box.lo[0] && p.x <= box.hi[0] && p.y >= box.lo[1] && p.y <= box.hi[1] && p.z >= box.lo[2] &&
                 p.z <= box.hi[2];
        }));
      }
    }
    if (most == 3 * boxes.size()) { EXPECT_LT(WideBvh::folded_cost(bvh), 0.6 * whole); }
  }
}

TEST(Scaling, ByAPowerOfTwoScalesTExactly) {
  Random random(3);
  auto build = [](int k) {
    double s = std::ldexp(1.0, k);
    SceneBuilder builder;
    uint32_t ball = builder.add_mesh(icosphere(2).transformed(s, Vec3(0.3 * s)).build(), "bvh");
    uint32_t sphere = builder.add_solid(Sphere{0.7 * s});
    return scene_of(builder, {{ball, translate(Vec3(s, 0, 0))}, {sphere, translate(Vec3(-s, 0, 0))}});
  };
  auto unit = build(0);
  for (int k : {-40, -11, 3, 40}) {
    auto scaled = build(k);
    for (int i = 0; i < 2000; ++i) {
      Ray ray = random_ray(random, 5.0);
      Hit a = closest(*unit, ray), b = closest(*scaled, {ray.origin * std::ldexp(1.0, k), ray.direction});
      ASSERT_EQ(a.primitive, b.primitive);
      if (a.found()) { ASSERT_EQ(std::ldexp(a.t, k), b.t); }
    }
  }
}

TEST(Instances, OfMillionsOfMillionsAreNumberedThrough) {
  SceneBuilder builder;
  uint32_t object = builder.add_solid(Sphere{0.4});
  for (int level = 0; level < 9; ++level) {  // 100^9 spheres = 1e18
    std::vector<InstanceSource> members;
    for (int i = 0; i < 100; ++i) members.push_back({object, translate({i - 49.5, 0.0, 0.0}) * scale(Vec3(0.01))});
    object = builder.add_group(members, "bvh");
    if (level != 3) continue;
    SceneBuilder four = builder;
    auto scene = four.build(object, {});
    EXPECT_EQ(closest(*scene, {Vec3(100, 0, 0), Vec3(-1, 0, 0)}).primitive, 99999999u);
  }
  EXPECT_THROW(
      {
        std::vector<InstanceSource> more(100, {object, Affine{}});
        builder.add_group(more, "auto");
      },
      Error);
  auto scene = builder.build(object, {});
  EXPECT_EQ(scene->objects[scene->root].primitives, 1000000000000000000u);
}

}  // namespace
}  // namespace tilecast
