#include <gtest/gtest.h>

#include <thread>

#include "base/counters.h"
#include "render/chunk.h"
#include "stress/scenes.h"
#include "shading/bsdf.h"

namespace tilecast {
namespace {

using namespace stress;

Rgb mean(const Scene& scene, uint32_t samples) {
  ChunkSums chunk = render_chunk(scene, {0, 0, scene.camera.width(), scene.camera.height()}, 0, samples);
  Rgb sum(0.0);
  for (size_t i = 0; i < chunk.sums.size(); ++i) sum[i % 3] += chunk.sums[i];
  return sum / (double(samples) * scene.camera.width() * scene.camera.height());
}

std::shared_ptr<const Scene> room(const char* accelerator, bool csg = false, bool light = true) {
  SceneBuilder builder;
  builder.set_camera(Camera(Vec3(0, 1, 6), Vec3(0), Vec3(0, 1, 0), 40, 32, 24));
  int white = builder.add_material({}), lamp = builder.add_material({.emission = Rgb(8.0)});
  int glass = builder.add_material({.kind = MaterialKind::Dielectric, .absorption = Rgb(0.1, 0.5, 1.0)});
  uint32_t floor = builder.add_rectangle(6, 6), square = builder.add_rectangle(1, 1);
  uint32_t ball = builder.add_mesh(icosphere(2).build(), accelerator), block = builder.add_solid(Block{Vec3(-0.5), Vec3(0.5)});
  std::vector<InstanceSource> list{{floor, translate(Vec3(0, -1, 0)), white}, {ball, translate(Vec3(-1, 0, 0)), glass},
                                   {block, translate(Vec3(1, -0.5, 0)), white}};
  if (light) list.push_back({square, translate(Vec3(0, 3, 0)) * rotate(kPi, Vec3(1, 0, 0)), lamp});
  if (csg)
    list.push_back({builder.add_csg(CsgOperation::Difference, {{block, Affine{}}, {ball, translate(Vec3(0.6))}}),
                    translate(Vec3(0, 1, 0)), white});
  builder.set_background(Rgb(0.2));
  return scene_of(builder, list, accelerator);
}

TEST(Chunk, DoesNotDependOnTilesThreadsOrAccelerators) {
  auto scene = room("bvh", true), brute = room("none", true);
  ChunkSums whole = render_chunk(*scene, {0, 0, 32, 24}, 4, 4);
  EXPECT_EQ(whole.sums, render_chunk(*brute, {0, 0, 32, 24}, 4, 4).sums);
  std::vector<std::thread> threads;
  std::vector<ChunkSums> tiles(12);
  for (int i = 0; i < 12; ++i)
    threads.emplace_back([&, i] { tiles[i] = render_chunk(*scene, {i % 4 * 8, i / 4 * 8, 8, 8}, 4, 4); });
  for (std::thread& thread : threads) thread.join();
  for (int half = 0; half < 2; ++half)
    for (int y = 0; y < 24; ++y)
      for (int x = 0; x < 32; ++x)
        for (int c = 0; c < 3; ++c)
          ASSERT_EQ(whole.sums[((half * 24 + y) * 32 + x) * 3 + c],
                    tiles[y / 8 * 4 + x / 8].sums[((half * 8 + y % 8) * 8 + x % 8) * 3 + c]);
}

#ifdef TILECAST_COUNTERS
TEST(Features, LeftOutOnesAreNeverEntered) {
  using namespace counters;
  auto without = room("bvh", false, false);
  EXPECT_EQ(std::count(without->features.begin(), without->features.end(), "csg"), 0);
  csg = 0, shadow = 0, texture = 0, solid = 0;
  render_chunk(*without, {0, 0, 32, 24}, 0, 4);
  EXPECT_EQ(csg, 0u);
  EXPECT_EQ(shadow, 0u);
  EXPECT_EQ(texture, 0u);
  EXPECT_GT(solid, 0u);
  auto with = room("bvh", true);
  EXPECT_EQ(std::count(with->features.begin(), with->features.end(), "csg"), 1);
  render_chunk(*with, {0, 0, 32, 24}, 0, 4);
  EXPECT_GT(csg, 0u);
  EXPECT_GT(shadow, 0u);
}
#endif

// A white furnace: whatever the material, with reflectance 1 nothing is seen against a background of radiance 1.
TEST(Furnace, WhiteMaterialsVanish) {
  for (MaterialKind kind : {MaterialKind::Diffuse, MaterialKind::Mirror, MaterialKind::Conductor, MaterialKind::Dielectric}) {
    SceneBuilder builder;
    builder.set_camera(Camera(Vec3(0, 0, 4), Vec3(0), Vec3(0, 1, 0), 40, 16, 16));
    builder.set_background(Rgb(1.0));
    int material = builder.add_material({.kind = kind, .reflectance = Rgb(1.0)});
    uint32_t ball = builder.add_solid(Sphere{1.0});
    auto scene = scene_of(builder, {{ball, Affine{}, material}}, "auto", {.max_depth = 10000});
    Rgb value = mean(*scene, 64);
    EXPECT_NEAR(value.x, 1.0, kind == MaterialKind::Dielectric ? 2e-3 : 1e-9) << static_cast<int>(kind);
  }
}

// Inside a closed diffuse sphere that emits E and reflects r everywhere, radiance is E (1 + r + r^2 + ...), cut at the depth.
TEST(Furnace, AnEmittingSphereFromInside) {
  for (bool next_event : {true, false}) {
    SceneBuilder builder;
    builder.set_camera(Camera(Vec3(0.1, 0.2, 0), Vec3(0, 0, -1), Vec3(0, 1, 0), 60, 16, 16));
    int material = builder.add_material({.reflectance = Rgb(0.5), .emission = Rgb(1.0)});
    MeshSource source = icosphere(2);
    for (auto& f : source.faces) std::swap(f.x, f.y);  // faces inwards
    uint32_t ball = builder.add_mesh(source.build(), "auto");
    auto scene = scene_of(builder, {{ball, Affine{}, material}}, "auto", {.max_depth = 6, .next_event = next_event});
    EXPECT_NEAR(mean(*scene, 256).x, 2.0 - std::ldexp(1.0, -5), 0.01);
  }
}

TEST(Roulette, EndsPathsWithoutAnyLossOfLight) {
  auto build = [](bool roulette) {
    SceneBuilder builder;
    builder.set_camera(Camera(Vec3(0), Vec3(0, 0, -1), Vec3(0, 1, 0), 40, 4, 4));
    int material = builder.add_material({.reflectance = Rgb(0.5), .emission = Rgb(1.0)});
    MeshSource source = icosphere(2);
    for (auto& f : source.faces) std::swap(f.x, f.y);  // faces inwards
    return scene_of(builder, {{builder.add_mesh(source.build(), "auto"), Affine{}, material}}, "auto",
                    {.max_depth = 30, .next_event = false, .roulette = roulette});
  };
  const double exact = 2.0 - std::ldexp(1.0, -29);
  ChunkSums whole = render_chunk(*build(false), {0, 0, 4, 4}, 0, 64), cut = render_chunk(*build(true), {0, 0, 4, 4}, 0, 64);
  for (double sum : whole.sums) EXPECT_NEAR(sum / 32, exact, 1e-12);  // no path differs from another
  EXPECT_EQ(whole.rays.bounce, 4 * 4 * 64 * 29u);
  EXPECT_LT(cut.rays.bounce, whole.rays.bounce / 4);
  EXPECT_NEAR(mean(*build(true), 4096).x, exact, 0.01);  // a path's deviation is 0.5: four standard errors
}

TEST(NextEvent, AgreesWithPathsThatFindTheLightByChance) {
  auto build = [](bool next_event) {
    SceneBuilder builder;
    builder.set_camera(Camera(Vec3(0, 1, 4), Vec3(0), Vec3(0, 1, 0), 30, 8, 8));
    int rough = builder.add_material({.kind = MaterialKind::Conductor, .reflectance = Rgb(0.8), .roughness = 0.6});
    int lamp = builder.add_material({.emission = Rgb(1.0)});
    uint32_t floor = builder.add_rectangle(6, 6);
    return scene_of(builder, {{floor, Affine{}, rough}, {floor, translate(Vec3(0, 3, 0)) * rotate(kPi, Vec3(1, 0, 0)), lamp}}, "auto",
                    {.max_depth = 2, .next_event = next_event});
  };
  EXPECT_NEAR(mean(*build(true), 1024).x, mean(*build(false), 1024).x, 2e-3);
}

TEST(PointLight, FollowsTheInverseSquareLaw) {
  SceneBuilder builder;
  builder.set_camera(Camera(Vec3(0, 1e-3, 0.1), Vec3(0, 0, 0), Vec3(0, 1, 0), 0.001, 1, 1));
  int white = builder.add_material({.reflectance = Rgb(0.5)});
  builder.add_point_light({Vec3(0, 2, 0), Rgb(12.0)});
  auto scene = scene_of(builder, {{builder.add_rectangle(1, 1), Affine{}, white}});
  EXPECT_NEAR(mean(*scene, 4).x, 0.5 / kPi * 12.0 / 4.0, 1e-4);
}

TEST(Absorption, FollowsBeersLawThroughASlab) {
  SceneBuilder builder;
  builder.set_camera(Camera(Vec3(0, 0, 5), Vec3(0), Vec3(0, 1, 0), 0.001, 1, 1));
  builder.set_background(Rgb(1.0));
  int tinted = builder.add_material({.kind = MaterialKind::Dielectric, .ior = 1.0, .absorption = Rgb(0.0, 0.5, 2.0)});
  uint32_t slab = builder.add_solid(Block{Vec3(-1, -1, -0.25), Vec3(1, 1, 0.25)});
  for (double start : {5.0, 0.0}) {  // from outside, and from its middle
    SceneBuilder b = builder;
    b.set_camera(Camera(Vec3(0, 0, start), Vec3(0, 0, -9), Vec3(0, 1, 0), 0.001, 1, 1));
    auto scene = scene_of(b, {{slab, Affine{}, tinted}});
    Rgb value = mean(*scene, 4);
    double length = start == 0.0 ? 0.25 : 0.5;
    EXPECT_NEAR(value.x, 1.0, 1e-12);
    EXPECT_NEAR(value.y, std::exp(-0.5 * length), 1e-9);
    EXPECT_NEAR(value.z, std::exp(-2.0 * length), 1e-9);
  }
}

TEST(Sampler, HasOneSampleInEachElementaryInterval) {
  for (uint32_t pixel = 0; pixel < 20; ++pixel)
    for (uint32_t half = 0; half < 2; ++half) {
      const int n = 64;
      for (int columns = 1; columns <= n; columns *= 2) {
        std::vector<int> first(n), second(n);
        for (int i = 0; i < n; ++i) {
          Sampler sampler(pixel, 7, 2 * i + half, 3);
          for (std::vector<int>* cells : {&first, &second}) {
            Vec2 u = sampler.next2();
            ++(*cells)[static_cast<int>(u.x * columns) * (n / columns) + static_cast<int>(u.y * (n / columns))];
          }
        }
        for (int i = 0; i < n; ++i) ASSERT_TRUE(first[i] == 1 && second[i] == 1);
      }
    }
}

TEST(Sampler, GivesIndependentPointsWhereTheyAreAskedFor) {
  // Pairs of a sample's numbers, and of one sample's and the next one's: chi-squared of 8 x 8 cells, 63 degrees of freedom.
  const int n = 1 << 16;
  const auto point = [](uint32_t sample) {
    Sampler sampler(5, 7, sample, 3, Sampling::Independent);
    sampler.next2();
    const double first = sampler.next1();
    const Vec2 u = sampler.next2();
    return std::array{first, u.x, u.y};
  };
  const std::pair<int, int> pairs[] = {{0, 1}, {1, 2}, {0, 3}, {1, 4}, {2, 5}, {1, 5}};
  std::vector<int> cells(std::size(pairs) * 64);
  for (uint32_t sample = 0; sample < n; ++sample) {
    const auto a = point(sample), b = point(sample + 2);  // of the same half
    const double numbers[] = {a[0], a[1], a[2], b[0], b[1], b[2]};
    for (size_t k = 0; k < std::size(pairs); ++k)
      ++cells[64 * k + static_cast<int>(8 * numbers[pairs[k].first]) * 8 + static_cast<int>(8 * numbers[pairs[k].second])];
  }
  for (size_t k = 0; k < std::size(pairs); ++k) {
    double chi_squared = 0.0;
    for (int i = 0; i < 64; ++i) chi_squared += std::pow(cells[64 * k + i] - n / 64.0, 2) / (n / 64.0);
    EXPECT_GT(chi_squared, 28.0) << k;   // 1e-4 either side
    EXPECT_LT(chi_squared, 112.0) << k;
  }
}

}  // namespace
}  // namespace tilecast
