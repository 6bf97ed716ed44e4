#include <gtest/gtest.h>

#include <functional>
#include <thread>

#include "base/counters.h"
#include "scene/csg.h"
#include "scene/surface.h"
#include "stress/scenes.h"

namespace tilecast {
namespace {

using namespace stress;
using Inside = std::function<bool(const Vec3&)>;

struct Shape {
  uint32_t object;
  Inside inside;
};

// A random tree and, beside it, its answer for single points.
Shape random_tree(SceneBuilder& builder, std::mt19937_64& random, int leaves) {
  if (leaves == 1) {
    switch (random() % 4) {
      case 0: return {builder.add_solid(Sphere{0.8}), [](const Vec3& p) { return glm::dot(p, p) < 0.64; }};
      case 1: return {builder.add_solid(Block{Vec3(-0.7), Vec3(0.7)}), [](const Vec3& p) { return max_abs(p) < 0.7; }};
      case 2:
        return {builder.add_solid(Cylinder{0.5, 1.4}),
                [](const Vec3& p) { return p.x * p.x + p.z * p.z < 0.25 && std::fabs(p.y) < 0.7; }};
      default:
        return {builder.add_mesh(gridded_cube(2).transformed(0.6, Vec3(0)).build(), "auto"),
                [](const Vec3& p) { return max_abs(p) < 0.6; }};
    }
  }
  auto operation = static_cast<CsgOperation>(random() % 3);
  std::vector<InstanceSource> operands;
  std::vector<Inside> parts;
  int children = leaves == 2 ? 2 : 2 + random() % 2;
  for (int i = 0; i < children; ++i) {
    int share = i + 1 < children ? leaves / children : leaves - (children - 1) * (leaves / children);
    Shape child = random_tree(builder, random, std::max(1, share));
    Affine to_parent = random_affine(random), to_local = inverse(to_parent);
    operands.push_back({child.object, to_parent});
    parts.push_back([inside = child.inside, to_local](const Vec3& p) { return inside(to_local.point(p)); });
  }
  Inside inside = [operation, parts](const Vec3& p) {
    bool result = parts[0](p);
    for (size_t i = 1; i < parts.size(); ++i) {
      bool part = parts[i](p);
      if (operation == CsgOperation::Union) result = result || part;
      if (operation == CsgOperation::Intersection) result = result && part;
      if (operation == CsgOperation::Difference) result = result && !part;
    }
    return result;
  };
  return {builder.add_csg(operation, operands), inside};
}

TEST(Csg, RandomTreesAgreeWithMembershipOfPoints) {
  std::mt19937_64 random(4);
  int checked = 0, inside_count = 0;
  for (int tree = 0; tree < 60; ++tree) {
    SceneBuilder builder;
    Shape shape = random_tree(builder, random, 2 + random() % 31);
    auto scene = builder.build(shape.object, {});
    for (int i = 0; i < 200; ++i) {
      Ray ray = random_ray(random, 4.0);
      std::vector<Crossing> list;
      crossings(*scene, ray, list);
      ASSERT_EQ(list.size() % 2, 0u);
      for (size_t k = 0; k < list.size(); ++k) {
        ASSERT_EQ(list[k].entering, k % 2 == 0);
        if (k > 0) { ASSERT_LT(list[k - 1].t, list[k].t); }
      }
      // Between any two crossings the answer is that of a point there.
      for (size_t k = 0; k <= list.size(); ++k) {
        double from = k == 0 ? -1.0 : list[k - 1].t, to = k == list.size() ? 3.0 : list[k].t;
        if (to - from < 1e-5) continue;
        double t = from + (to - from) * 0.382;
        ASSERT_EQ(shape.inside(ray.at(t)), k % 2 == 1);
        ++checked;
        inside_count += k % 2;
      }
      Hit hit = closest(*scene, ray);
      auto first = std::find_if(list.begin(), list.end(), [](const Crossing& c) { return c.t > 0.0; });
      ASSERT_EQ(hit.found(), first != list.end());
      if (hit.found()) { ASSERT_EQ(hit.t, first->t); }
    }
  }
  EXPECT_GT(checked, 10000);
  EXPECT_GT(inside_count, 1000);
}

TEST(Csg, CoincidentFacesLeaveNoSliver) {
  enum Operand { kBlock, kMesh };
  struct Arrangement {
    CsgOperation operation;
    Operand a, b;
    double offset;     // of b along x
    size_t crossings;  // of a line along x through the middle
  } arrangements[] = {
      {CsgOperation::Union, kBlock, kBlock, 2, 2},  // side by side: no wall between
      {CsgOperation::Union, kBlock, kMesh, 2, 2},
      {CsgOperation::Union, kBlock, kMesh, 0, 2},  // the same place
      {CsgOperation::Intersection, kBlock, kMesh, 2, 0},  // they only touch
      {CsgOperation::Difference, kBlock, kMesh, 0, 0},    // nothing is left
      {CsgOperation::Difference, kBlock, kBlock, 1, 2},   // flush on four sides
      {CsgOperation::Difference, kMesh, kBlock, 2, 2},    // beside
  };
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(-0.9, 0.9);
  for (const Arrangement& a : arrangements) {
    SceneBuilder builder;
    uint32_t objects[2] = {builder.add_solid(Block{Vec3(-1), Vec3(1)}), builder.add_mesh(gridded_cube(3).build(), "auto")};
    uint32_t csg = builder.add_csg(a.operation, {{objects[a.a], Affine{}}, {objects[a.b], translate(Vec3(a.offset, 0, 0))}});
    Affine turn = rotate(0.7, glm::normalize(Vec3(1, 2, 3)));
    auto scene = scene_of(builder, {{csg, turn}});
    for (int i = 0; i < 2000; ++i) {
      Vec3 from{-6.0, unit(random), unit(random)}, to{9.0, unit(random), unit(random)};
      std::vector<Crossing> list;
      crossings(*scene, {turn.point(from), turn.vector(to - from)}, list);
      ASSERT_EQ(list.size(), a.crossings) << "arrangement " << (&a - arrangements);
    }
  }
}

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

TEST(Csg, AChainOf100000OperationsNeedsNoStack) {
  SceneBuilder builder;
  uint32_t ball = builder.add_solid(Sphere{0.5});
  uint32_t chain = ball;
  for (int i = 1; i <= 100000; ++i) chain = builder.add_csg(CsgOperation::Union, {{ball, translate(Vec3(0.5 * i, 0, 0))}, {chain, Affine{}}});
  std::shared_ptr<const Scene> scene;
  size_t count = 0;
  // 256 KiB of stack; sanitizers need more for themselves.
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, 256 * 1024);
  struct Work {
    SceneBuilder* builder;
    uint32_t root;
    size_t* count;
  } work{&builder, chain, &count};
  pthread_t thread;
  ASSERT_EQ(pthread_create(&thread, &attributes, [](void* p) -> void* {
              Work& w = *static_cast<Work*>(p);
              auto scene = w.builder->build(w.root, {});
              std::vector<Crossing> list;
              crossings(*scene, {Vec3(-5, 0, 0.1), Vec3(1, 0, 0)}, list);
              *w.count = list.size();
              return nullptr;
            }, &work), 0);
  pthread_join(thread, nullptr);
  EXPECT_EQ(count, 2u);
}

// A box minus `count` balls, which take away as much however many they are.
std::shared_ptr<const Scene> cheese(int count) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(-1, 1), size(0.08, 0.23);
  SceneBuilder builder;
  std::vector<InstanceSource> operands{{builder.add_solid(Block{Vec3(-1.0), Vec3(1.0)}), Affine{}}};
  for (int i = 0; i < count; ++i)
    operands.push_back({builder.add_solid(Sphere{size(random) * std::cbrt(100.0 / count)}),
                        translate({unit(random), unit(random), unit(random)})});
  return scene_of(builder, {{builder.add_csg(CsgOperation::Difference, operands), Affine{}}});
}

TEST(Csg, LooksAtFewOfManyOperands) {
  uint64_t looked_at[2];
  for (bool many : {false, true}) {
    auto scene = cheese(many ? 10000 : 100);
    std::mt19937_64 random(1);
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

TEST(Csg, StopsAtTheFirstCrossingThatTheWholeLineHas) {
  auto scene = cheese(1000);
  std::mt19937_64 random(2);
  std::vector<Crossing> whole;
  for (int i = 0; i < 20000; ++i) {
    Ray ray = random_ray(random, i % 2 ? 3.0 : 0.7);
    crossings(*scene, ray, whole);
    auto first = std::find_if(whole.begin(), whole.end(), [](const Crossing& c) { return c.t > 0.0; });
    Hit hit = closest(*scene, ray);
    ASSERT_EQ(hit.found(), first != whole.end());
    if (!hit.found()) continue;
    ASSERT_EQ(hit.t, first->t);
    ASSERT_EQ(hit.primitive, first->primitive);
    ASSERT_EQ(hit.entering, first->entering);
    ray.t_max = hit.t;
    ASSERT_TRUE(occluded(*scene, ray));
    ray.t_max = std::nextafter(hit.t, 0.0);
    ASSERT_FALSE(occluded(*scene, ray));
  }
}

}  // namespace
}  // namespace tilecast
