// Ambient occlusion and the integrator "direct" against closed forms.
#include <gtest/gtest.h>

#include "estimates.h"
#include "stress/scenes.h"

namespace tilecast {
namespace {

using namespace stress;

std::shared_ptr<const Scene> corner(double wall, SceneBuilder::Options options) {
  options.integrator = Integrator::AmbientOcclusion;
  SceneBuilder builder;
  builder.set_camera(Camera(Vec3(0.3, 0.4, 0), Vec3(0), Vec3(0, 1, 0), 1e-9, 16, 16));
  std::vector<InstanceSource> list{{builder.add_rectangle(1e4, 1e4), Affine{}}};
  if (wall > 0.0) list.push_back({builder.add_rectangle(wall, 1e4), translate(Vec3(-2, 0.5 * wall, 0)) * rotate(-kPi / 2, Vec3(0, 0, 1))});
  return scene_of(builder, list, "auto", options);
}

TEST(AmbientOcclusion, IsOneOnAPlaneAndWhereNothingIs) {
  EXPECT_EQ(estimate(*corner(0.0, {}), 16).mean, 1.0);
  SceneBuilder builder;
  builder.set_camera(Camera(Vec3(0, 0, 1), Vec3(0), Vec3(0, 1, 0), 40, 4, 4));
  EXPECT_EQ(estimate(*scene_of(builder, {}, "auto", {.integrator = Integrator::AmbientOcclusion}), 4).mean, 1.0);
}

// A wall of height h at a distance a, endless both ways, hides 1/2 (1 - a / sqrt(a^2 + h^2)) of the hemisphere; the ends of
// this one, 5,000 metres away, less than 1e-6.
TEST(AmbientOcclusion, HasAClosedFormBesideAWall) {
  for (double height : {0.5, 3.0, 1e4})
    expect_near(estimate(*corner(height, {}), 256), 1.0 - 0.5 * (1.0 - 2.0 / std::hypot(2.0, height)));
}

// The wall is 2 metres away: nothing of it lies within less, and some of it within more.
TEST(AmbientOcclusion, LooksNoFartherThanItsDistance) {
  EXPECT_EQ(estimate(*corner(3.0, {.ao_distance = 1.999}), 64).mean, 1.0);
  EXPECT_LT(estimate(*corner(3.0, {.ao_distance = 2.5}), 64).mean, 1.0);
  EXPECT_GT(estimate(*corner(3.0, {.ao_distance = 2.5}), 64).mean, estimate(*corner(3.0, {}), 64).mean);
}

TEST(AmbientOcclusion, LeavesOutLightsAndMaterials) {
  SceneBuilder builder;
  builder.add_point_light({Vec3(0, 5, 0), Rgb(10.0)});
  int glass = builder.add_material({.kind = MaterialKind::Dielectric});
  auto scene = scene_of(builder, {{builder.add_rectangle(2, 2), Affine{}, glass}}, "none", {.integrator = Integrator::AmbientOcclusion});
  EXPECT_EQ(scene->features, (std::vector<std::string>{"rectangle", "shadow_rays"}));
  EXPECT_EQ(scene->lights.count(), 0u);
}

TEST(Direct, IsAPathOfTwoSegments) {
  auto room = [](Integrator integrator, int depth) {
    SceneBuilder builder;
    builder.set_camera(Camera(Vec3(0, 1, 6), Vec3(0), Vec3(0, 1, 0), 40, 16, 12));
    builder.set_background(Rgb(0.3));
    builder.add_point_light({Vec3(1, 3, 1), Rgb(10.0)});
    int metal = builder.add_material({.kind = MaterialKind::Conductor, .reflectance = Rgb(0.9), .roughness = 0.3});
    return scene_of(builder, {{builder.add_rectangle(6, 6), translate(Vec3(0, -1, 0))}, {builder.add_solid(Sphere{1.0}), Affine{}, metal}},
                    "auto", {.integrator = integrator, .max_depth = depth});
  };
  for (int depth : {1, 2, 8})
    EXPECT_EQ(render_chunk(*room(Integrator::Direct, depth), {0, 0, 16, 12}, 0, 8).sums,
              render_chunk(*room(Integrator::Path, std::min(depth, 2)), {0, 0, 16, 12}, 0, 8).sums);
}

}  // namespace
}  // namespace tilecast
