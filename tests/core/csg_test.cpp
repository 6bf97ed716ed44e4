#include <gtest/gtest.h>

#include "base/counters.h"
#include "scene/csg.h"
#include "scene/packet.h"
#include "scene/surface.h"
#include "stress/scenes.h"
#include "stress/shapes.h"

namespace tilecast {
namespace {

using namespace stress;

TEST(Csg, ADrilledHoleHasTheDrillsMaterialAndFacesInwards) {
  SceneBuilder builder;
  int brass = builder.add_material({}), steel = builder.add_material({});
  uint32_t block = builder.add_solid(Block{Vec3(-1), Vec3(1)}), drill = builder.add_solid(Cylinder{0.5, 4.0});
  uint32_t part = builder.add_csg(CsgOperation::Difference, {{block, Affine{}}, {drill, Affine{}, steel}});
  auto scene = scene_of(builder, {{part, Affine{}, brass}});
  Ray ray{Vec3(0, 0, 0), Vec3(1, 0, 0)};
  Hit hit = closest(*scene, ray);
  ASSERT_TRUE(hit.found());
  EXPECT_EQ(hit.t, 0.5);
  EXPECT_TRUE(hit.entering);
  Surface surface = resolve(*scene, ray, hit);
  EXPECT_EQ(surface.material, &scene->materials[steel]);
  EXPECT_EQ(surface.normal, Vec3(-1, 0, 0));
  EXPECT_EQ(resolve(*scene, {Vec3(3, 0, 0), Vec3(-1, 0, 0)}, closest(*scene, {Vec3(3, 0, 0), Vec3(-1, 0, 0)})).material,
            &scene->materials[brass]);
}

TEST(Csg, AMeshTurnedInsideOutIsStillAnOperand) {
  MeshSource source = icosphere(2);
  for (auto& f : source.faces) std::swap(f.x, f.y);
  SceneBuilder builder;
  uint32_t ball = builder.add_mesh(source.build(), "auto"), block = builder.add_solid(Block{Vec3(-2), Vec3(2)});
  auto scene = builder.build(builder.add_csg(CsgOperation::Difference, {{block, Affine{}}, {ball, Affine{}}}), {});
  std::vector<Crossing> list;
  crossings(*scene, {Vec3(-5, 0.1, 0.1), Vec3(1, 0, 0)}, list);
  EXPECT_EQ(list.size(), 4u);
}

TEST(Csg, RefusesWhatIsOpenAndNamesIt) {
  SceneBuilder builder;
  uint32_t block = builder.add_solid(Block{Vec3(-1), Vec3(1)}), rectangle = builder.add_rectangle(1, 1);
  MeshSource source = icosphere(1);
  source.faces.pop_back();
  uint32_t open = builder.add_mesh(source.build(), "auto");
  auto message = [&](std::vector<InstanceSource> operands) {
    try {
      builder.add_csg(CsgOperation::Union, operands);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(message({{block, Affine{}}, {rectangle, Affine{}}}).find("of[1]: a rectangle is open"), std::string::npos);
  EXPECT_NE(message({{open, Affine{}}, {block, Affine{}}}).find("of[0]: the mesh is not closed"), std::string::npos);
  EXPECT_NE(message({{block, Affine{}}}).find("at least 2 operands"), std::string::npos);
}

// What a line in a face, or nearly, crosses of the object with that face is anybody's guess; of all others it is not.
TEST(Csg, ALineThatGrazesAFaceTakesNothingFromTheOtherOperands) {
  Random random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  const Vec3 lo(0.0, -0.5, -0.5), hi(0.6, 0.5, 0.5);
  for (int kind = 0; kind < 3; ++kind)
    for (bool ball_first : {false, true})
      for (auto operation : {CsgOperation::Union, CsgOperation::Difference})
        for (const Affine& place : {Affine{}, translate({0.3, 0.1, 0.0}) * rotate(0.5, Vec3(0, 0, 1))}) {
          if (operation == CsgOperation::Difference && !ball_first) continue;  // takes the ball away
          SceneBuilder builder;
          const uint32_t ball = builder.add_solid(Sphere{1.2});
          const uint32_t box = kind == 0   ? builder.add_solid(Block{lo, hi})
                               : kind == 1 ? builder.add_solid(RoundedBlock{lo, hi, 0.1})
                                           : builder.add_mesh(gridded_cube(2).transformed(0.5, Vec3(0.5, 0, 0)).build(), "bvh");
          std::vector<InstanceSource> of{{ball, place}, {box, place}};
          if (!ball_first) std::swap(of[0], of[1]);
          auto scene = scene_of(builder, {{builder.add_csg(operation, of), Affine{}}});
          for (int exponent : {-400, -300, -20, -17, -16, -15, -14, -12, -10, -8, -7, -6, -4}) {
            for (int i = 0; i < 20; ++i) {
              const Vec3 direction(std::pow(10.0, exponent) * (i % 2 ? 1.0 : -1.0), 0.3 * unit(random), 1.0);
              const Vec3 middle(0.0, 0.3 * unit(random), 0.0);
              const Ray line{place.point(middle - 5.0 * direction), place.vector(direction)};
              const double b = glm::dot(middle, direction), a = glm::dot(direction, direction);
              const double half = std::sqrt(b * b - a * (glm::dot(middle, middle) - 1.44)) / a;
              std::vector<Crossing> list;
              crossings(*scene, line, list);
              ASSERT_GE(list.size(), 2u) << kind << ", 1e" << exponent;
              if (operation == CsgOperation::Union) {
                ASSERT_EQ(list.size(), 2u) << kind << ", 1e" << exponent;
              }
              EXPECT_NEAR(list.front().t, 5.0 - b / a - half, 1e-13) << kind << ", 1e" << exponent;
              EXPECT_NEAR(list.back().t, 5.0 - b / a + half, 1e-13) << kind << ", 1e" << exponent;
              EXPECT_EQ(closest(*scene, line).t, list.front().t);
              Ray inside = line;
              inside.t_min = 5.0;
              const auto next = std::find_if(list.begin(), list.end(), [](const Crossing& c) { return c.t > 5.0; });
              EXPECT_EQ(closest(*scene, inside).t, next->t) << kind << ", 1e" << exponent;
            }
          }
        }
}

TEST(Csg, NothingDoubledAgainAndAgainIsNothing) {
  SceneBuilder builder;
  uint32_t nothing = builder.add_group({}, "auto");
  for (int level = 0; level < 60; ++level) nothing = builder.add_group({{nothing, Affine{}}, {nothing, Affine{}}}, "auto");
  const uint32_t ball = builder.add_solid(Sphere{1.0});
  Material shining;
  shining.emission = Rgb(1.0);
  std::vector<InstanceSource> parts;
  for (auto operation : {CsgOperation::Difference, CsgOperation::Union, CsgOperation::Intersection})
    parts.push_back({builder.add_csg(operation, {{ball, Affine{}}, {nothing, Affine{}}}), translate({4.0 * parts.size(), 0, 0})});
  parts.push_back({nothing, Affine{}, builder.add_material(shining)});
  auto scene = scene_of(builder, parts);
  EXPECT_TRUE(scene->lights.areas.empty());
  for (int i = 0; i < 3; ++i)
    EXPECT_EQ(closest(*scene, {Vec3(4.0 * i, 0, 5), Vec3(0, 0, -1)}).found(), i < 2) << i;
}

// A box minus `count` balls, which take away as much however many they are.
std::shared_ptr<const Scene> cheese(int count) {
  Random random(7);
  std::uniform_real_distribution<double> unit(-1, 1), size(0.08, 0.23);
  SceneBuilder builder;
  std::vector<InstanceSource> operands{{builder.add_solid(Block{Vec3(-1.0), Vec3(1.0)}), Affine{}}};
  for (int i = 0; i < count; ++i)
    operands.push_back({builder.add_solid(Sphere{size(random) * std::cbrt(100.0 / count)}),
                        translate({unit(random), unit(random), unit(random)})});
  return scene_of(builder, {{builder.add_csg(CsgOperation::Difference, operands), Affine{}}});
}

#ifdef TILECAST_COUNTERS
TEST(Csg, LooksAtFewOfManyOperands) {
  uint64_t looked_at[2];
  for (bool many : {false, true}) {
    auto scene = cheese(many ? 10000 : 100);
    Random random(1);
    counters::solid = 0;
    for (int i = 0; i < 10000; ++i) {
      Ray ray = random_ray(random, 4.0);
      Hit hit = closest(*scene, ray);
      if (hit.found()) occluded(*scene, {resolve(*scene, ray, hit).spawn(-ray.direction), Vec3(1.0, 2.0, 1.0)});
    }
    looked_at[many] = counters::solid;
  }
  EXPECT_LT(looked_at[1], 3 * looked_at[0]);
}
#endif

// The first hit, and whether anything is in the way, are what the crossings of the whole line say.
void expect_first_of_line(const Scene& scene, Ray ray) {
  thread_local std::vector<Crossing> whole;
  crossings(scene, ray, whole);
  auto first = std::find_if(whole.begin(), whole.end(), [](const Crossing& c) { return c.t > 0.0; });
  Hit hit = closest(scene, ray);
  ASSERT_EQ(hit.found(), first != whole.end());
  if (!hit.found()) return;
  ASSERT_EQ(hit.t, first->t);
  ASSERT_EQ(hit.primitive, first->primitive);
  ASSERT_EQ(hit.entering, first->entering);
  ray.t_max = hit.t;
  ASSERT_TRUE(occluded(scene, ray));
  ray.t_max = std::nextafter(hit.t, 0.0);
  ASSERT_FALSE(occluded(scene, ray));
}

TEST(Csg, StopsAtTheFirstCrossingThatTheWholeLineHas) {
  Random random(2);
  for (int count : {30, 1000, 10000}) {  // one level of boxes to three, one stretch to many
    auto scene = cheese(count);
    for (int i = 0; i < 10000; ++i) expect_first_of_line(*scene, random_ray(random, i % 2 ? 3.0 : 0.7));
  }
}

// Solids of every kind about a metre large; half of them where others are, so that faces coincide.
uint32_t random_tree(SceneBuilder& builder, Random& random, int operands) {
  std::vector<InstanceSource> of;
  const auto operation = static_cast<CsgOperation>(random() % 3);
  const int children = std::min(operands, 2 + static_cast<int>(random() % 3));
  for (int i = 0; i < children; ++i) {
    const int share = operands / children + (i < operands % children);
    const Solid solids[] = {Sphere{0.8}, Block{Vec3(-0.7), Vec3(0.7)}, Cylinder{0.5, 1.4}, Cone{0.8, 0.0, 1.4},
                            Capsule{0.5, 0.6}, Torus{0.7, 0.2}, RoundedBlock{Vec3(-0.7), Vec3(0.7), 0.2},
                            random_quadric(random, 0.7), Sphere{1e-7}, Cylinder{0.5, 1e-9}};
    uint32_t object = share > 1 ? random_tree(builder, random, share)
                                : builder.add_solid(solids[random() % std::size(solids)]);
    if (i > 0 && operation != CsgOperation::Union && share == 1 && random() % 8 == 0)
      object = builder.add_solid(Halfspace::of(random_direction(random), 0.1));
    Affine place = random_affine(random);
    if (random() & 1) place = rotate(kPi / 2 * (random() % 4), Vec3(0, 1, 0));
    if (random() % 4 == 0) place = translate({0.0, 0.7, 0.0});
    of.push_back({object, place});
  }
  return builder.add_csg(operation, of);
}

TEST(Csg, FindsWhatTheWalkAlongTheWholeLineFindsBitForBit) {
  Random random(3);
  for (int tree = 0; tree < 300; ++tree) {
    SceneBuilder builder;
    const int operands = tree % 2 ? 2 + random() % 7 : 2 + random() % 40;
    uint32_t root = random_tree(builder, random, operands);
    auto scene = scene_of(builder, {{root, tree % 3 ? random_affine(random) : Affine{}}});
    for (int i = 0; i < 300; ++i) {
      Ray ray = random_ray(random, i % 3 ? 3.0 : 0.7);
      if (i % 5 == 0) ray.direction[random() % 3] = 0.0;
      if (i % 7 == 0) ray = {ray.origin, Vec3(0, -1, 0)};
      if (i % 11 == 0) ray.origin -= 1e6 * ray.direction;
      expect_first_of_line(*scene, ray);
      Hit hit = closest(*scene, ray);
      if (!hit.found()) continue;
      Vec3 direction = random_direction(random);
      expect_first_of_line(*scene, {resolve(*scene, ray, hit).spawn(direction), direction});
      if (testing::Test::HasFailure()) FAIL() << "tree " << tree << ", ray " << i;
    }
  }
}

// Many rays at once get what each gets alone: all of the hit, to the last bit.
void expect_as_alone(const Scene& scene, const std::vector<Ray>& rays) {
  std::vector<Hit> hits(rays.size());
  std::unique_ptr<bool[]> found = std::make_unique<bool[]>(rays.size());
  closest(scene, rays, hits.data());
  occluded(scene, rays, found.get());
  for (size_t i = 0; i < rays.size(); ++i) {
    const Hit hit = closest(scene, rays[i]);
    ASSERT_EQ(hits[i].primitive, hit.primitive);
    ASSERT_EQ(std::bit_cast<uint64_t>(hits[i].t), std::bit_cast<uint64_t>(hit.t));
    ASSERT_EQ(hits[i].entering, hit.entering);
    ASSERT_EQ(hits[i].u, hit.u);
    ASSERT_EQ(hits[i].v, hit.v);
    ASSERT_EQ(found[i], occluded(scene, rays[i]));
  }
}

// From about one place, in about one direction, by so much.
std::vector<Ray> rays_about(Random& random, const Ray& middle, double by, int count) {
  std::uniform_real_distribution<double> unit(-by, by);
  std::vector<Ray> rays;
  for (int i = 0; i < count; ++i) {
    Ray ray = middle;
    for (int k = 0; k < 3; ++k) ray.origin[k] += unit(random), ray.direction[k] += unit(random);
    rays.push_back(ray);
  }
  return rays;
}

// The rays themselves, and what goes on where they end: off the surface, on behind it, back, and as far as to it.
void expect_as_alone_and_after(const Scene& scene, Random& random, const std::vector<Ray>& rays) {
  expect_as_alone(scene, rays);
  std::vector<Ray> spawned, behind, ended, parallel;
  const Vec3 direction = random_direction(random);
  for (const Ray& ray : rays) {
    const Hit hit = closest(scene, ray);
    if (!hit.found()) continue;
    const Surface surface = resolve(scene, ray, hit);
    const Vec3 towards = random() % 4 ? Vec3(20.0, 30.0, 10.0) - surface.point : -ray.direction;
    spawned.push_back({surface.spawn(towards), towards, 0.0, 1.0});
    parallel.push_back({surface.spawn(direction), direction});
    behind.push_back({ray.origin, ray.direction, hit.t, random() % 2 ? kInfinity : 2.0 * std::fabs(hit.t)});
    ended.push_back({ray.origin, ray.direction, 0.0, random() % 2 ? hit.t : std::nextafter(hit.t, 0.0)});
  }
  for (const std::vector<Ray>* more : {&spawned, &behind, &ended, &parallel}) expect_as_alone(scene, *more);
}

TEST(Csg, GivesManyRaysAtOnceWhatEachGetsAlone) {
  Random random(4);
  for (int tree = 0; tree < 400; ++tree) {
    SceneBuilder builder;
    std::vector<InstanceSource> instances;
    const int count = std::array{1, 2, 7, 60}[tree % 4];
    const uint32_t roots[] = {random_tree(builder, random, 2 + random() % 7), random_tree(builder, random, 2 + random() % (tree % 5 ? 7 : 40))};
    for (int i = 0; i < count; ++i) {
      const Affine place = i % 3 ? translate(3.0 * random_direction(random)) : random_affine(random);
      instances.push_back({roots[random() % 2], count > 1 ? place : random() % 2 ? random_affine(random) : Affine{}});
    }
    if (tree % 3 == 0) instances.push_back({builder.add_rectangle(9.0, 9.0), translate({0.0, -0.5, 0.0})});
    if (tree % 11 == 0) instances.push_back({builder.add_solid(Torus{0.7, 0.2}), random_affine(random)});
    if (tree % 13 == 0) instances.push_back({builder.add_mesh(icosphere(2).build(), "auto"), random_affine(random)});
    auto scene = scene_of(builder, instances);
    for (int i = 0; i < 20; ++i) {
      Ray middle = random_ray(random, i % 3 ? 3.0 : 0.7);
      if (i % 5 == 0) middle.direction[random() % 3] = 0.0;
      if (i % 11 == 0) middle.origin -= 1e6 * middle.direction;
      if (i % 13 == 0) middle.direction *= 0x1p40;
      expect_as_alone_and_after(*scene, random, rays_about(random, middle, std::array{0.0, 1e-6, 1e-2, 1.0}[i % 4], 1 + random() % 29));
      if (HasFatalFailure()) FAIL() << "tree " << tree << ", rays " << i;
    }
  }
}

TEST(Csg, GivesManyRaysAtOnceWhatEachGetsAloneWhereNumbersAreExtreme) {
  SceneBuilder builder;
  uint32_t block = builder.add_solid(Block{Vec3(-1), Vec3(1)}), drill = builder.add_solid(Cylinder{0.5, 4.0});
  uint32_t part = builder.add_csg(CsgOperation::Difference, {{block, Affine{}}, {drill, Affine{}}});
  auto scene = scene_of(builder, {{part, Affine{}}, {part, translate({1e6, 0, 0})}, {part, translate({2, 0, 0})}});
  const double odd[] = {0.0, -0.0, 1.0, -1.0, 1e-320, 1e300, kInfinity, std::nan(""), 0x1p-60, 0.5};
  Random random(5);
  for (int i = 0; i < 20000; ++i) {
    std::vector<Ray> rays(8);
    for (Ray& ray : rays) {
      for (int k = 0; k < 3; ++k) ray.origin[k] = odd[random() % std::size(odd)], ray.direction[k] = odd[random() % std::size(odd)];
      ray.t_min = random() % 4 ? 0.0 : 0.5, ray.t_max = random() % 2 ? kInfinity : 1.0;
    }
    expect_as_alone(*scene, rays);
    if (HasFatalFailure()) FAIL() << i;
  }
}

}  // namespace
}  // namespace tilecast
