// Views against closed forms: the test draws the same camera rays and works out on its own what they meet.
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "base/counters.h"
#include "render/chunk.h"
#include "stress/scenes.h"

namespace tilecast {
namespace {

using namespace stress;

constexpr int kViewWidth = 48, kViewHeight = 32;

// Renders one sample a pixel and gives each ray with its colour.
template <class Check>
void for_each_sample(const Scene& scene, Check&& check) {
  ChunkSums chunk = render_chunk(scene, {0, 0, kViewWidth, kViewHeight}, 0, 1);
  EXPECT_EQ(chunk.rays.camera, uint64_t(kViewWidth) * kViewHeight);
  EXPECT_EQ(chunk.rays.bounce + chunk.rays.shadow, 0u);
  for (int y = 0; y < kViewHeight; ++y)
    for (int x = 0; x < kViewWidth; ++x) {
      Vec2 jitter = Sampler(x, y, 0, scene.seed).next2();
      const double* c = &chunk.sums[3 * (y * kViewWidth + x)];
      check(scene.camera.ray(x + jitter.x, y + jitter.y), Rgb(c[0], c[1], c[2]));
    }
}

SceneBuilder with_camera() {
  SceneBuilder builder;
  builder.set_camera(Camera(Vec3(0.5, 1, 6), Vec3(0), Vec3(0, 1, 0), 40, kViewWidth, kViewHeight));
  return builder;
}

// A ball of radius 1 about `centre`, seen from outside.
std::shared_ptr<const Scene> ball(Integrator integrator, const Vec3& centre) {
  SceneBuilder builder = with_camera();
  return scene_of(builder, {{builder.add_solid(Sphere{1.0}), translate(centre)}}, "auto", {.integrator = integrator});
}

// Where a ray enters that ball; negative: nowhere.
double entry(const Ray& ray, const Vec3& centre) {
  long double b = 0, c = -1;
  for (int i = 0; i < 3; ++i) {
    long double o = static_cast<long double>(ray.origin[i]) - centre[i];
    b += o * ray.direction[i];
    c += o * o;
  }
  long double discriminant = b * b - c;
  return discriminant < 0 ? -1.0 : static_cast<double>(-b - std::sqrt(discriminant));
}

const Vec3 kCentre(0.3, -0.2, -0.5);
// Rounding moves a discriminant by at most 8 u |origin - centre|^2, and at grazing incidence t by the root of that.
const double kGrazing = std::sqrt(8 * kUnitRoundoff * 44);

TEST(Views, DepthIsInMetresAlongTheRay) {
  int hits = 0;
  for_each_sample(*ball(Integrator::Depth, kCentre), [&](const Ray& ray, const Rgb& colour) {
    double t = entry(ray, kCentre);
    if (t < 0) {
      EXPECT_EQ(colour, Rgb(0.0));
    } else {
      EXPECT_NEAR(colour.x, t, kGrazing);
      EXPECT_TRUE(colour.x == colour.y && colour.y == colour.z);
      ++hits;
    }
  });
  EXPECT_GT(hits, 100);
}

TEST(Views, NormalsPointOutwardsInWorldSpace) {
  for_each_sample(*ball(Integrator::Normals, kCentre), [&](const Ray& ray, const Rgb& colour) {
    double t = entry(ray, kCentre);
    Rgb expected = t < 0 ? Rgb(0.0) : 0.5 + 0.5 * (ray.at(t) - kCentre);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(colour[i], expected[i], kGrazing);
  });
}

TEST(Views, FrontsAreBlueAndBacksAreRed) {
  for (bool inside_out : {false, true}) {
    SceneBuilder builder = with_camera();
    MeshSource source = icosphere(2);
    if (inside_out)
      for (auto& face : source.faces) std::swap(face.x, face.y);
    auto scene = scene_of(builder, {{builder.add_mesh(source.build(), "auto"), Affine{}}}, "auto",
                          {.integrator = Integrator::Facing});
    int hits = 0;
    for_each_sample(*scene, [&](const Ray&, const Rgb& colour) {
      if (colour == Rgb(0.0)) return;
      EXPECT_EQ(inside_out, colour.x > colour.z);
      ++hits;
    });
    EXPECT_GT(hits, 100);
  }
}

TEST(Views, FacingFallsWithTheCosine) {
  for_each_sample(*ball(Integrator::Facing, kCentre), [&](const Ray& ray, const Rgb& colour) {
    double t = entry(ray, kCentre);
    double cosine = t < 0 ? 0.0 : -glm::dot(ray.at(t) - kCentre, ray.direction);
    EXPECT_NEAR(colour.z, t < 0 ? 0.0 : 0.2 + 0.8 * cosine, kGrazing);
  });
}

// Two instances of a group of two balls and a part made of two operands: 5 placed objects.
std::shared_ptr<const Scene> crowd(Integrator integrator) {
  SceneBuilder builder = with_camera();
  uint32_t mesh = builder.add_mesh(icosphere(1).build(), "auto");
  uint32_t block = builder.add_solid(Block{Vec3(-0.5), Vec3(0.5)});
  Affine left = translate(Vec3(-1.5, 0, 0)) * scale(Vec3(0.5));
  uint32_t pair = builder.add_group({{mesh, left}, {block, Affine{}}}, "auto");
  uint32_t part = builder.add_csg(CsgOperation::Difference, {{block, Affine{}}, {mesh, translate(Vec3(0, 0, 1))}});
  return scene_of(builder, {{pair, translate(Vec3(0, 1, 0))}, {pair, translate(Vec3(0, -1, 0))},
                            {part, translate(Vec3(1.5, 0, 0))}}, "auto", {.integrator = integrator});
}

TEST(Views, APrimitiveHasOneColourAndNoOtherHasIt) {
  auto scene = crowd(Integrator::Primitives);
  std::map<uint64_t, Rgb> colours;
  std::set<std::array<double, 3>> distinct;
  for_each_sample(*scene, [&](const Ray& ray, const Rgb& colour) {
    Hit hit = closest(*scene, ray);
    if (!hit.found()) {
      EXPECT_EQ(colour, Rgb(0.0));
      return;
    }
    EXPECT_GE(std::min({colour.x, colour.y, colour.z}), 0.1);
    EXPECT_EQ(colours.try_emplace(hit.primitive, colour).first->second, colour);
    distinct.insert({colour.x, colour.y, colour.z});
  });
  EXPECT_GT(colours.size(), 30u);
  EXPECT_EQ(distinct.size(), colours.size());
}

TEST(Views, APlacedObjectHasOneColour) {
  auto scene = crowd(Integrator::Instances);
  std::map<int, std::set<std::array<double, 3>>> colours;  // by the place in the picture
  for_each_sample(*scene, [&](const Ray& ray, const Rgb& colour) {
    Hit hit = closest(*scene, ray);
    if (!hit.found()) return;
    Vec3 p = ray.at(hit.t);
    int place = p.x > 0.75 ? 0 : 1 + (p.y > 0) + 2 * (p.x < -0.75);
    colours[place].insert({colour.x, colour.y, colour.z});
  });
  EXPECT_EQ(colours.size(), 5u);
  std::set<std::array<double, 3>> all;
  for (const auto& [place, found] : colours) {
    EXPECT_EQ(found.size(), 1u) << place;
    all.insert(found.begin(), found.end());
  }
  EXPECT_EQ(all.size(), 5u);
}

TEST(Views, LeaveOutLightMediaAndMaterials) {
  for (int view = static_cast<int>(Integrator::Normals); view < static_cast<int>(std::size(kIntegratorNames)); ++view) {
    SceneBuilder builder = with_camera();
    int glass = builder.add_material({.kind = MaterialKind::Dielectric, .ior = 1.5});
    int lamp = builder.add_material({.emission = Rgb(5.0)});
    builder.add_point_light({Vec3(0, 5, 0), Rgb(10.0)});
    builder.set_background(Rgb(1.0));
    uint32_t mesh = builder.add_mesh(icosphere(1).build(), "auto"), square = builder.add_rectangle(2, 2);
    auto scene = scene_of(builder, {{mesh, Affine{}, glass}, {square, translate(Vec3(0, 2, 0)), lamp}}, "auto",
                          {.integrator = static_cast<Integrator>(view)});
    EXPECT_EQ(scene->features, (std::vector<std::string>{"hierarchy", "mesh", "rectangle"}));
    EXPECT_EQ(scene->lights.count(), 0u);
#ifdef TILECAST_COUNTERS
    counters::shadow = counters::medium = counters::texture = 0;
    for_each_sample(*scene, [](const Ray&, const Rgb&) {});
    EXPECT_EQ(counters::shadow + counters::medium + counters::texture, 0u);
#endif
    EXPECT_EQ(kernel_name(*scene).find(kIntegratorNames[view]), 0u);
  }
}

}  // namespace
}  // namespace tilecast
