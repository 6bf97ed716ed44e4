#include <gtest/gtest.h>

#include "base/counters.h"
#include "scene/csg.h"
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
  auto scene = cheese(1000);
  Random random(2);
  for (int i = 0; i < 20000; ++i) expect_first_of_line(*scene, random_ray(random, i % 2 ? 3.0 : 0.7));
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

}  // namespace
}  // namespace tilecast
