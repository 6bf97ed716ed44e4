// What lights bring to a surface, against closed forms; and next-event estimation against paths that find lights by chance.
#include <gtest/gtest.h>

#include <random>

#include "estimates.h"
#include "integrators/ball_light.h"
#include "stress/scenes.h"

namespace tilecast {
namespace {

using namespace stress;

// A floor of reflectance 1 at y = 0, seen in one point: its radiance times pi is the irradiance there.
SceneBuilder spot_of_floor(std::vector<InstanceSource>& list, double from = 0.05) {
  SceneBuilder builder;
  builder.set_camera(Camera(Vec3(0, from, 0), Vec3(0), Vec3(1, 0, 0), 1e-9, 16, 16));
  list = {{builder.add_rectangle(20, 20), Affine{}, builder.add_material({.reflectance = Rgb(1.0)})}};
  return builder;
}

Estimate irradiance(const Scene& scene, uint32_t samples = 64) {
  Estimate found = estimate(scene, samples);
  return {found.mean * kPi, found.error * kPi};
}

constexpr Integrator kLit[] = {Integrator::Path, Integrator::Direct, Integrator::Whitted};

TEST(SpotLight, IsSmoothBetweenItsAngles) {
  for (double angle : {0.0, 14.9, 20.0, 25.0, 29.0, 30.1, 120.0}) {  // of the floor's point off the axis
    std::vector<InstanceSource> list;
    SceneBuilder builder = spot_of_floor(list);
    const double a = angle * kPi / 180, inner = std::cos(15 * kPi / 180), outer = std::cos(30 * kPi / 180);
    builder.add_spot_light({Vec3(0, 2, 0), Vec3(3 * std::sin(a), -3 * std::cos(a), 0), Rgb(8.0), inner, outer});
    const double x = std::clamp((std::cos(a) - outer) / (inner - outer), 0.0, 1.0);
    for (Integrator integrator : kLit) {
      SceneBuilder copy = builder;
      auto scene = scene_of(copy, list, "auto", {.integrator = integrator});
      EXPECT_NEAR(irradiance(*scene, 2).mean, 8.0 / 4.0 * x * x * (3 - 2 * x), 1e-9) << angle;
    }
  }
}

TEST(SpotLight, MayHaveAHardEdge) {
  for (double angle : {29.9, 30.1}) {
    std::vector<InstanceSource> list;
    SceneBuilder builder = spot_of_floor(list);
    const double a = angle * kPi / 180, edge = std::cos(30 * kPi / 180);
    builder.add_spot_light({Vec3(0, 2, 0), Vec3(std::sin(a), -std::cos(a), 0), Rgb(8.0), edge, edge});
    EXPECT_NEAR(irradiance(*scene_of(builder, list), 2).mean, angle < 30 ? 2.0 : 0.0, 1e-9);
  }
}

TEST(DirectionalLight, FollowsTheCosineAndIsBlockedHoweverFar) {
  for (bool blocked : {false, true})
    for (Integrator integrator : kLit) {
      std::vector<InstanceSource> list;
      SceneBuilder builder = spot_of_floor(list);
      builder.add_directional_light({Vec3(-3, -4, 0), Rgb(5.0)});
      if (blocked) list.push_back({builder.add_solid(Sphere{1e5}), translate(1e7 * Vec3(3, 4, 0))});
      auto scene = scene_of(builder, list, "auto", {.integrator = integrator});
      EXPECT_NEAR(irradiance(*scene, 2).mean, blocked ? 0.0 : 5.0 * 0.8, 1e-9);
    }
}

TEST(DirectionalLight, PassesThroughGlassInWhittedShadows) {
  std::vector<InstanceSource> list;
  SceneBuilder builder = spot_of_floor(list);
  builder.add_directional_light({Vec3(0, -1, 0), Rgb(5.0)});
  int glass = builder.add_material({.kind = MaterialKind::Dielectric, .ior = 1.5, .absorption = Rgb(0.3)});
  list.push_back({builder.add_solid(Block{Vec3(-5, 1, -5), Vec3(5, 3, 5)}), Affine{}, glass});
  auto scene = scene_of(builder, list, "auto", {.integrator = Integrator::Whitted, .max_depth = 9});
  EXPECT_NEAR(irradiance(*scene, 2).mean, 5.0 * 0.96 * 0.96 * std::exp(-0.6), 1e-9);
}

int lamp(SceneBuilder& builder, double radiance) {
  return builder.add_material({.reflectance = Rgb(0.0), .emission = Rgb(radiance)});
}

// Radiance L, radius r, distance d, cosine c at the floor: E = pi L (r / d)^2 c for a ball above the horizon, however small
// or near. The ball is placed by a similarity.
TEST(BallLight, FollowsTheInverseSquareLawExactly) {
  for (auto [radius, distance] : {std::pair(1.0, 2.0), std::pair(1.0, 1.001), std::pair(1e-4, 2.0), std::pair(1e-14, 2.0),
                                  std::pair(1e-4, 1.0001e-4), std::pair(1e3, 1e6)}) {
    const Vec3 way = distance > 2.0 * radius ? Vec3(0.48, 0.8, 0.36) : Vec3(0, 1, 0);
    std::vector<InstanceSource> list;
    SceneBuilder builder = spot_of_floor(list, std::min(0.05, 0.5 * (distance - radius)));
    const Affine place = translate(distance * way) * rotate(0.7, glm::normalize(Vec3(1, 2, 3))) * scale(Vec3(-0.5 * radius));
    list.push_back({builder.add_solid(Sphere{2.0}), place, lamp(builder, 3.0 / (radius * radius))});
    auto scene = scene_of(builder, list);
    ASSERT_EQ(scene->lights.areas.size(), 1u);
    const Estimate found = irradiance(*scene);
    const double exact = kPi * 3.0 / (distance * distance) * way.y;
    expect_near(found, exact);
    EXPECT_LT(found.error, 0.01 * exact);  // 0.7 of it in all if points were uniform over the surface
  }
}

TEST(BallLight, IsTinyAndBright) {
  std::vector<InstanceSource> list;
  SceneBuilder builder = spot_of_floor(list);
  list.push_back({builder.add_solid(Sphere{1e-4}), translate(Vec3(0, 2, 0)), lamp(builder, 1e8)});
  EXPECT_NEAR(irradiance(*scene_of(builder, list)).mean, kPi * 1e8 * 1e-8 / 4.0, 1e-6);
}

TEST(BallLight, SendsNothingInwards) {
  std::vector<InstanceSource> list;
  SceneBuilder builder = spot_of_floor(list);
  list.push_back({builder.add_solid(Sphere{3.0}), Affine{}, lamp(builder, 1.0)});
  EXPECT_EQ(irradiance(*scene_of(builder, list)).mean, 0.0);
}

TEST(DiskLight, AboveAPoint) {
  std::vector<InstanceSource> list;
  SceneBuilder builder = spot_of_floor(list);
  list.push_back({builder.add_flat(Disk{1.5}), translate(Vec3(0, 2, 0)) * rotate(kPi, Vec3(1, 0, 0)), lamp(builder, 3.0)});
  expect_near(irradiance(*scene_of(builder, list)), kPi * 3.0 * 1.5 * 1.5 / (1.5 * 1.5 + 4.0));
}

// A rectangle a x b, parallel to the floor at height h, with a corner above the point: E = L / 2 (A / sqrt(1 + A^2)
// atan(B / sqrt(1 + A^2)) + B / sqrt(1 + B^2) atan(A / sqrt(1 + B^2))), A = a / h, B = b / h.
TEST(RectangleLight, WithACornerAboveAPoint) {
  std::vector<InstanceSource> list;
  SceneBuilder builder = spot_of_floor(list);
  list.push_back({builder.add_rectangle(2, 3), translate(Vec3(1, 1.5, 1.5)) * rotate(kPi, Vec3(1, 0, 0)), lamp(builder, 3.0)});
  const double A = 2 / 1.5, B = 3 / 1.5, ra = std::sqrt(1 + A * A), rb = std::sqrt(1 + B * B);
  expect_near(irradiance(*scene_of(builder, list)), 3.0 / 2 * (A / ra * std::atan(B / ra) + B / rb * std::atan(A / rb)));
}

TEST(Lights, OfNoPowerAreNoLights) {
  SceneBuilder builder;
  builder.set_camera(Camera(Vec3(0, 1, 4), Vec3(0), Vec3(0, 1, 0), 60, 8, 8));
  builder.add_point_light({Vec3(0, 1, 0), Rgb(0.0)});
  builder.add_spot_light({Vec3(0, 1, 0), Vec3(0, -1, 0), Rgb(0.0), 0.9, 0.8});
  builder.add_spot_light({Vec3(0, 1, 0), Vec3(0, -1, 0), Rgb(9.0), 1.0, 1.0});
  builder.add_directional_light({Vec3(0, -1, 0), Rgb(0.0)});
  int dark = builder.add_material({.emission = Rgb(0.0)});
  auto scene = scene_of(builder, {{builder.add_rectangle(2, 2), Affine{}}, {builder.add_solid(Sphere{0.1}), Affine{}, dark}});
  EXPECT_EQ(scene->lights.count(), 0u);
  for (double value : render_chunk(*scene, {0, 0, 8, 8}, 0, 4).sums) EXPECT_EQ(value, 0.0);
}

// --- All kinds of lights together with and without next-event estimation

enum class Lamp { Rectangle, Disk, Mesh, Ball, NearBall, Ellipsoid, Environment, Many };

std::shared_ptr<const Scene> lit(Lamp kind, MaterialKind material, bool next_event) {
  SceneBuilder builder;
  builder.set_camera(Camera(Vec3(0, 1.5, 4), Vec3(0), Vec3(0, 1, 0), 30, 16, 16));
  int floor = builder.add_material({.kind = material, .reflectance = Rgb(0.8), .roughness = 0.6}), light = lamp(builder, 2.0);
  std::vector<InstanceSource> list{{builder.add_rectangle(6, 6), Affine{}, floor},
                                   {builder.add_solid(Block{Vec3(-0.4), Vec3(0.4)}), translate(Vec3(-1, 0.4, 0)), floor}};
  const Affine down = translate(Vec3(0.5, 1.2, 0)) * rotate(kPi, Vec3(1, 0, 0));
  switch (kind) {
    case Lamp::Rectangle: list.push_back({builder.add_rectangle(1.5, 1), down, light}); break;
    case Lamp::Disk: list.push_back({builder.add_flat(Disk{0.8}), down * scale(Vec3(1, 1, 0.5)), light}); break;
    case Lamp::Mesh: list.push_back({builder.add_mesh(icosphere(1).build(), "auto"), down * scale(Vec3(0.6, 0.2, 0.6)), light}); break;
    case Lamp::Ball: list.push_back({builder.add_solid(Sphere{0.5}), down, light}); break;
    case Lamp::NearBall: list.push_back({builder.add_solid(Sphere{0.5}), translate(Vec3(0.5, 0.5, 0)), light}); break;
    case Lamp::Ellipsoid: list.push_back({builder.add_solid(Sphere{0.5}), down * scale(Vec3(1, 0.7, 1)), light}); break;
    case Lamp::Environment: {
      std::vector<Vec3f> pixels(32, Vec3f(0.2f));
      pixels[5] = Vec3f(9.0f);
      builder.set_environment(Environment(std::move(pixels), 8, 4, 30.0));
      break;
    }
    case Lamp::Many:
      for (int i = 0; i < 12; ++i) {
        const Affine place = translate(Vec3(i % 4 - 1.5, 1.0 + 0.1 * i, i / 4 - 1.0)) * rotate(2.0 + 0.2 * i, Vec3(1, 0, 0));
        list.push_back({i % 3 ? builder.add_rectangle(0.5, 0.7) : builder.add_solid(Sphere{0.2}), place, light});
      }
  }
  return scene_of(builder, list, "auto", {.max_depth = 2, .next_event = next_event});
}

TEST(NextEvent, AgreesWithChanceForEveryLight) {
  for (Lamp kind : {Lamp::Rectangle, Lamp::Disk, Lamp::Mesh, Lamp::Ball, Lamp::NearBall, Lamp::Ellipsoid, Lamp::Environment, Lamp::Many})
    for (MaterialKind material : {MaterialKind::Diffuse, MaterialKind::Conductor}) {
      auto with = lit(kind, material, true), without = lit(kind, material, false);
      ASSERT_EQ(with->lights.has_tree(), kind == Lamp::Many);
      // Pixel by pixel, since pixels differ more than samples of one do.
      ChunkSums a = render_chunk(*with, {0, 0, 16, 16}, 0, 256), b = render_chunk(*without, {0, 0, 16, 16}, 0, 256);
      double sum = 0.0, squares = 0.0, all = 0.0;
      for (int i = 0; i < 256; ++i) {
        const double x = a.sums[3 * i] + a.sums[3 * (256 + i)], y = b.sums[3 * i] + b.sums[3 * (256 + i)];
        sum += x - y, squares += (x - y) * (x - y), all += y;
      }
      EXPECT_GT(all, 0.0);
      EXPECT_LE(std::fabs(sum), 4.5 * std::sqrt(squares)) << static_cast<int>(kind) << " " << static_cast<int>(material);
    }
}

TEST(BallCone, IsSampledUniformly) {
  for (auto [radius, distance] : {std::pair(1.0, 1.5), std::pair(1.0, 1.0 + 1e-6), std::pair(1e-6, 1.0), std::pair(1e-60, 3.0)}) {
    const Vec3 to_centre = distance * glm::normalize(Vec3(0.3, -0.5, 0.8));
    const BallCone cone = cone_of(to_centre, radius);
    const long double r = radius, d = distance, s2 = (r / d) * (r / d);
    const double exact = static_cast<double>(s2 / (1 + std::sqrt(1 - s2)));
    EXPECT_NEAR(cone.one_minus_cosine, exact, 1e-9 * exact);  // 1 + 1e-6 has lost 1e-10 of the rest before we begin
    EXPECT_NEAR(cone.pdf() * 2 * kPi * exact, 1.0, 1e-9);
    Random random(2);
    std::uniform_real_distribution<double> unit(0, 1);
    constexpr int kSide = 8, kSamples = 100'000;
    std::vector<double> counts(kSide * kSide), expected(kSide * kSide, double(kSamples) / (kSide * kSide));
    const Basis basis(to_centre / glm::length(to_centre));
    for (int i = 0; i < kSamples; ++i) {
      const Vec3 normal = sample_normal(cone, to_centre, {unit(random), unit(random)});
      ASSERT_NEAR(glm::length(normal), 1.0, 1e-14);
      // The angle off the axis, from the triangle of the eye, the centre and the point; in the cone's units.
      const Vec3 n = basis.to_local(normal);
      const double aside = radius * std::hypot(n.x, n.y), ahead = distance + radius * n.z;
      const double sine = aside / std::hypot(aside, ahead), v = sine * sine / (1 + ahead / std::hypot(aside, ahead));
      ASSERT_LE(glm::dot(to_centre + radius * normal, normal), 1e-9 * distance);  // its front
      const int row = std::min(kSide - 1, static_cast<int>(v / exact * kSide));
      const double turn = std::atan2(n.y, n.x) / (2 * kPi);
      const int column = std::min(kSide - 1, static_cast<int>((turn - std::floor(turn)) * kSide));
      ++counts[row * kSide + column];
    }
    expect_distributed(counts, expected);
  }
}

}  // namespace
}  // namespace tilecast
