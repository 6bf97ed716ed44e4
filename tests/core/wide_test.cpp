// The kernels for vectors against the test of a single triangle, bit for bit.
#include <gtest/gtest.h>

#include "accel/accelerated_mesh.h"
#include "accel/ray_order.h"
#include "stress/meshes.h"

namespace tilecast {
namespace {

using stress::MeshSource;

bool same(double a, double b) { return std::bit_cast<uint64_t>(a) == std::bit_cast<uint64_t>(b); }

bool same(const FaceHit& a, const FaceHit& b) {
  return a.face == b.face && a.entering == b.entering && same(a.t, b.t) && same(a.u, b.u) && same(a.v, b.v);
}

// Every triangle by geometry/triangle.h.
FaceHit brute_force(const Mesh& mesh, const Ray& ray, std::vector<FaceHit>* all = nullptr) {
  FaceHit best;
  FrameRay line;
  if (!enter_frame(mesh.frame, ray, line)) return best;
  for (uint32_t face = 0; face < mesh.faces.size(); ++face) {
    TriangleHit hit;
    if (!intersect(line, mesh.triangle(face), hit) || !(hit.t > ray.t_min && hit.t <= ray.t_max)) continue;
    if (all) all->push_back({hit.t, hit.u, hit.v, face, hit.entering});
    if (hit.t < best.t) best = {hit.t, hit.u, hit.v, face, hit.entering};
  }
  return best;
}

struct Place {
  double scale;
  Vec3 offset;
};

MeshSource tangle(stress::Random& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  MeshSource source;
  for (uint32_t i = 0; i < 300; ++i) {
    const double size = std::exp2(-10.0 * std::fabs(unit(random)));
    Vec3 centre{unit(random), unit(random), unit(random)};
    for (int k = 0; k < 3; ++k) source.vertices.push_back(centre + size * Vec3{unit(random), unit(random), unit(random)});
    source.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return source;
}

// Of every kind: coherent blocks, along axes, at vertices and edges, from inside, with ends, past the mesh, and garbage.
std::vector<Ray> rays_at(const Mesh& mesh, const Place& place, stress::Random& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<Ray> rays;
  auto from = [&](const Vec3& p) { return place.offset + place.scale * p; };
  for (int block = 0; block < 40; ++block) {
    Vec3 eye = 3.0 * stress::random_direction(random), at = Vec3{unit(random), unit(random), unit(random)};
    const double apart = std::array{0.02, 0.1, 0.4}[block % 3];  // narrow packets, and such that part on the way
    for (int k = 0; k < (block < 8 ? 64 : 16); ++k)  // first such that all go together
      rays.push_back({from(eye), place.scale * (at - eye + apart * Vec3{unit(random), unit(random), unit(random)})});
  }
  for (int i = 0; i < 600; ++i) {
    Vec3 origin = from((i & 1 ? 3.0 : 0.5) * Vec3{unit(random), unit(random), unit(random)});
    Vec3 target = stress::vertex_or_edge_point(mesh, random);
    Ray ray{origin, target - origin};
    if (i % 5 == 0) ray.t_max = 1.0;
    if (i % 7 == 0) ray.t_min = 0.5;
    if (i % 11 == 0) ray.t_min = -kInfinity;
    rays.push_back(ray);
  }
  for (int i = 0; i < 54; ++i) {
    auto component = [&](int digit) { return digit == 0 ? (i & 1 ? -0.0 : 0.0) : digit == 1 ? 1.0 : -1.0; };
    Vec3 direction{component(i / 2 % 3), component(i / 6 % 3), component(i / 18 % 3)};
    rays.push_back({from(-2.0 * direction), direction});
  }
  const double odd[] = {0.0, -0.0, 1e-320, 1e308, kInfinity, -kInfinity, std::numeric_limits<double>::quiet_NaN(), 1.0};
  for (int i = 0; i < 200; ++i) {
    auto pick = [&] { return odd[random() % 8]; };
    rays.push_back({{pick(), pick(), pick()}, {pick(), pick(), pick()}, i & 1 ? 0.0 : pick(), i & 2 ? kInfinity : pick()});
  }
  return rays;
}

TEST(WideBvh, AnswersAsBruteForceBitForBit) {
  stress::Random random(5);
  const std::vector<MeshSource> sources{stress::icosphere(3), stress::gridded_cube(6), tangle(random),
                                        stress::with_collinear_faces(stress::icosphere(2)),
                                        MeshSource{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, std::vector<glm::uvec3>(50, {0, 1, 2})}};
  uint64_t found = 0;
  for (const MeshSource& source : sources)
    for (const Place& place : {Place{1.0, Vec3(0.0)}, Place{1e-6, Vec3(1.0, 2.0, -3.0)}, Place{1e6, Vec3(-5e7, 1e3, 0.0)}})
      for (const char* kind : {"bvh", "sbvh"}) {
        AcceleratedMesh mesh(source.transformed(place.scale, place.offset).build(), kind);
        const std::vector<Ray> rays = rays_at(mesh.mesh(), place, random);
        std::vector<FaceHit> together(rays.size());
        std::vector<uint32_t> stopped(rays.size());
        mesh.closest(rays, together.data());
        mesh.occluded(rays, stopped.data());
        for (size_t i = 0; i < rays.size(); ++i) {
          std::vector<FaceHit> all;
          const FaceHit expected = brute_force(mesh.mesh(), rays[i], &all);
          found += expected.face != FaceHit::kNone;
          NoCost free;
          TraversalCost cost;
          ASSERT_TRUE(same(expected, mesh.closest(rays[i], free))) << i;
          ASSERT_TRUE(same(expected, mesh.closest(rays[i], cost))) << i;
          ASSERT_TRUE(same(expected, together[i])) << i;
          auto is_hit = [&](uint32_t face) {
            return std::any_of(all.begin(), all.end(), [&](const FaceHit& hit) { return hit.face == face; });
          };
          for (uint32_t face : {stopped[i], mesh.occluded(rays[i])})
            ASSERT_TRUE(face == FaceHit::kNone ? all.empty() : is_hit(face)) << i;
          std::vector<FaceHit> hits = mesh.all_hits(rays[i]);
          std::sort(hits.begin(), hits.end(), [](const FaceHit& a, const FaceHit& b) { return a.face < b.face; });
          hits.erase(std::unique(hits.begin(), hits.end(), [](const FaceHit& a, const FaceHit& b) { return same(a, b); }), hits.end());
          ASSERT_EQ(hits.size(), all.size()) << i;
          for (size_t k = 0; k < all.size(); ++k) ASSERT_TRUE(same(all[k], hits[k])) << i;
        }
      }
  EXPECT_GT(found, 10000u);
}

TEST(WideBvh, LargeBatchesOutOfOrderAnswerAsSingleRays) {
  for (int levels : {4, 7}) {  // the larger one is not left to the cache
    stress::Random random(6);
    AcceleratedMesh mesh(stress::icosphere(levels).build(), "bvh");
    EXPECT_EQ(mesh.bytes() > 16'000'000, levels == 7);
    std::vector<Ray> rays(5001);
    for (Ray& ray : rays) ray = {0.9 * stress::random_direction(random), stress::random_direction(random)};
    EXPECT_EQ(order_for_cache(mesh.mesh().frame, rays).size(), rays.size());
    std::vector<FaceHit> hits(rays.size());
    mesh.closest(rays, hits.data());
    NoCost free;
    for (size_t i = 0; i < rays.size(); ++i) ASSERT_TRUE(same(hits[i], mesh.closest(rays[i], free)));
  }
}

TEST(WideBvh, BatchesOfAnySizeAnswerAsSingleRays) {
  stress::Random random(8);
  AcceleratedMesh mesh(tangle(random).build(), "bvh");
  std::vector<Ray> rays(200);
  for (Ray& ray : rays) ray = {0.5 * stress::random_direction(random), stress::random_direction(random)};
  NoCost free;
  for (size_t count : {1, 3, 15, 16, 17, 63, 64, 65, 127, 200}) {
    const FaceHit untouched{.t = -1.0, .face = 77};
    std::vector<FaceHit> hits(rays.size() + 1, untouched);
    mesh.closest(std::span(rays).first(count), hits.data());
    for (size_t i = 0; i < count; ++i) ASSERT_TRUE(same(hits[i], mesh.closest(rays[i], free))) << count << ", " << i;
    ASSERT_TRUE(same(hits[count], untouched)) << count;
  }
}

// Boxes one in another, which meet in a corner: from there, lines meet the innermost first, and all the others wait, which
// are more than a stream has room for.
TEST(WideBvh, NestedBoxesAnswerAsBruteForce) {
  MeshSource source;
  for (uint32_t i = 0; i < 1000; ++i) {
    const double r = std::exp2(-0.02 * i);
    for (const Vec3& p : {Vec3(r, 0, 0), Vec3(0, r, 0), Vec3(0, 0, r)}) source.vertices.push_back(p);
    source.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  AcceleratedMesh mesh(source.build(), "bvh");
  stress::Random random(9);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Ray> rays;
  for (int i = 0; i < 300; ++i) {  // there and back, so that they do not go as packets
    const Vec3 along = (i & 1 ? -1.0 : 1.0) * Vec3(unit(random), unit(random), unit(random));
    rays.push_back({1e-6 * unit(random) - 4.0 * along, along});
  }
  std::vector<FaceHit> hits(rays.size());
  std::vector<uint32_t> faces(rays.size());
  mesh.closest(rays, hits.data());
  mesh.occluded(rays, faces.data());
  for (size_t i = 0; i < rays.size(); ++i) {
    const FaceHit expected = brute_force(mesh.mesh(), rays[i]);
    ASSERT_TRUE(same(hits[i], expected)) << i;
    ASSERT_EQ(faces[i] != FaceHit::kNone, expected.face != FaceHit::kNone) << i;
  }
}

}  // namespace
}  // namespace tilecast
