// Scattering functions in scenes, and what they are computed with. What holds for each of them by itself (density,
// energy, reciprocity) is among the hazards: core/stress/scattering.cpp.
#include <gtest/gtest.h>

#include <complex>

#include "optics/fresnel.h"
#include "render/chunk.h"
#include "stress/scenes.h"

namespace tilecast {
namespace {

using namespace stress;

TEST(Elementary, FunctionsAgreeWithLongDouble) {
  Random random(1);
  std::uniform_real_distribution<double> unit(0, 1), exponent(-300, 300);
  for (int i = 0; i < 100000; ++i) {
    double x = unit(random);
    if (i % 3 == 1) x = std::exp2(-60 * x);
    if (i % 3 == 2) x = 1.0 - std::exp2(-1 - 50 * x);
    long double exact = std::acos(static_cast<long double>(x));
    ASSERT_NEAR(acos_unit(x), exact, 4 * kUnitRoundoff * exact) << x;
    double wide = i % 2 ? std::pow(10.0, exponent(random)) : 0.5 + unit(random);
    exact = std::log(static_cast<long double>(wide));
    ASSERT_NEAR(log_positive(wide), exact, 8 * kUnitRoundoff * std::fabs(exact)) << wide;
    double y = 1000 * unit(random);
    exact = std::pow(static_cast<long double>(x), static_cast<long double>(y));
    double magnified = 16 - 8 * y * std::log(std::max(x, 1e-300));  // the rounding of y ln x
    ASSERT_NEAR(power_of_unit(x, y), exact, magnified * kUnitRoundoff * exact + 1e-300) << x << " " << y;
  }
  EXPECT_EQ(power_of_unit(0.0, 2.0), 0.0);
  EXPECT_EQ(power_of_unit(0.0, 0.0), 1.0);
  EXPECT_EQ(power_of_unit(1.0, 1e6), 1.0);
  EXPECT_EQ(acos_unit(1.0), 0.0);
}

TEST(Fresnel, OfConductorsIsThatOfTheirComplexIndex) {
  using Complex = std::complex<long double>;
  const std::pair<double, double> metals[]{{0.18, 3.4}, {1.37, 1.77}, {2.9, 3.1}, {1.5, 0.0}, {1e-3, 1e3}};
  for (auto [eta, k] : metals)
    for (int i = 0; i <= 1000; ++i) {
      double cosine = i / 1000.0;
      Complex n(eta, k), c(cosine), inside = std::sqrt(Complex(1) - (Complex(1) - c * c) / (n * n));
      long double s = std::norm((c - n * inside) / (c + n * inside)), p = std::norm((n * c - inside) / (n * c + inside));
      ASSERT_NEAR(fresnel_conductor(cosine, eta, k), 0.5L * (s + p), 1e-13) << eta << " " << cosine;
    }
}

// The sums of the samples of each pixel and of their squares, red channel.
struct Pixels {
  std::vector<double> mean, error;  // error: one standard error of the mean
};
Pixels render(const Scene& scene, uint32_t samples) {
  const int width = scene.camera.width(), height = scene.camera.height();
  Pixels out{std::vector<double>(width * height), std::vector<double>(width * height)};
  for (uint32_t sample = 0; sample < samples; ++sample) {
    ChunkSums chunk = render_chunk(scene, {0, 0, width, height}, sample, 1);
    for (int i = 0; i < width * height; ++i) {
      double value = chunk.sums[3 * i] + chunk.sums[3 * (width * height + i)];
      out.mean[i] += value / samples;
      out.error[i] += value * value / samples;
    }
  }
  for (size_t i = 0; i < out.mean.size(); ++i)
    out.error[i] = std::sqrt(std::max(0.0, out.error[i] - out.mean[i] * out.mean[i]) / samples);
  return out;
}

struct Named {
  const char* name;
  Material material;
};
const std::vector<Named>& rough_materials() {
  using enum MaterialKind;
  static const std::vector<Named> all{
      {"clay", {.kind = Diffuse, .reflectance = Rgb(1.0), .roughness = 0.7}},
      {"metal", {.kind = Conductor, .reflectance = Rgb(1.0), .roughness = 0.5}},
      {"plastic", {.kind = Plastic, .reflectance = Rgb(1.0)}},
      {"rough plastic", {.kind = Plastic, .reflectance = Rgb(1.0), .roughness = 0.5}},
      {"frosted glass", {.kind = Dielectric, .roughness = 0.5}},
      {"half a mirror", {.kind = Mirror, .reflectance = Rgb(1.0), .opacity = 0.5}},
  };
  return all;
}

// Gate 29 per pixel: white balls in uniform light cannot be seen.
TEST(Furnace, EveryPixelOfAWhiteBallIsWhite) {
  for (const auto& [name, material] : rough_materials()) {
    SceneBuilder builder;
    builder.set_camera(Camera(Vec3(0, 0, 4), Vec3(0), Vec3(0, 1, 0), 30, 8, 8));
    builder.set_background(Rgb(1.0));
    int handle = builder.add_material(material);
    auto scene = scene_of(builder, {{builder.add_solid(Sphere{1.0}), Affine{}, handle}}, "auto", {.max_depth = 1000});
    Pixels pixels = render(*scene, 256);
    for (size_t i = 0; i < pixels.mean.size(); ++i)  // 5 standard errors: one pixel in 1.7 million by chance
      ASSERT_NEAR(pixels.mean[i], 1.0, 1e-4 + 5.0 * pixels.error[i]) << name << ", pixel " << i;
  }
}

// A sheet between two lamps, seen from one side: what light sampling finds is what paths find by chance.
TEST(NextEvent, AgreesWithChanceForEveryMaterial) {
  using enum MaterialKind;
  std::vector<Named> list = rough_materials();
  list.push_back({"phong", {.kind = Phong, .reflectance = Rgb(0.4), .specular = Rgb(0.5), .exponent = 30}});
  list.push_back({"blend", {.kind = Blend}});
  for (const auto& [name, given] : list) {
    auto build = [&, given = given](bool next_event) {
      SceneBuilder builder;
      builder.set_camera(Camera(Vec3(0, 1, 2), Vec3(0), Vec3(0, 1, 0), 10, 4, 4));
      Material material = given;
      if (material.kind == Blend)
        for (int i = 0; i < 3; ++i) {
          const MaterialKind kinds[]{Plastic, Conductor, Dielectric};
          const double roughness = i == 0 ? 0.0 : 0.5;
          material.parts[i] = builder.add_material({.kind = kinds[i], .reflectance = Rgb(0.7), .roughness = roughness});
          material.shares[i] = i == 0 ? 0.5 : 0.25;
        }
      int sheet = builder.add_material(material), above = builder.add_material({.emission = Rgb(1.0)});
      int below = builder.add_material({.emission = Rgb(3.0), .opacity = 0.5});
      uint32_t square = builder.add_rectangle(1.5, 1.5);
      return scene_of(builder, {{builder.add_rectangle(9, 9), Affine{}, sheet},
                                {square, translate(Vec3(0.2, 0.9, -0.4)) * rotate(kPi, Vec3(1, 0, 0)), above},
                                {square, translate(Vec3(-0.2, -0.9, 0)), below}},
                      "auto", {.max_depth = 2, .next_event = next_event});
    };
    double mean[2] = {0, 0}, square[2] = {0, 0};
    for (bool next_event : {false, true}) {
      Pixels pixels = render(*build(next_event), next_event ? 512 : 4096);
      for (size_t i = 0; i < pixels.mean.size(); ++i) {
        mean[next_event] += pixels.mean[i];
        square[next_event] += pixels.error[i] * pixels.error[i];
      }
    }
    EXPECT_GT(mean[0], 0.05) << name;
    EXPECT_NEAR(mean[0], mean[1], 5.0 * std::sqrt(square[0] + square[1]) + 1e-12) << name;
  }
}

// Inside a closed diffuse ball that emits 1 and reflects a, radiance is 1 + a + a^2 + ... up to the depth, whatever
// roulette does on the way.
TEST(Roulette, IsUnbiased) {
  for (double a : {0.3, 0.8}) {
    SceneBuilder builder;
    builder.set_camera(Camera(Vec3(0.1, 0.2, 0), Vec3(0, 0, -1), Vec3(0, 1, 0), 60, 8, 8));
    int material = builder.add_material({.reflectance = Rgb(a), .emission = Rgb(1.0)});
    MeshSource source = icosphere(1);
    for (auto& f : source.faces) std::swap(f.x, f.y);  // faces inwards
    auto scene = scene_of(builder, {{builder.add_mesh(source.build(), "auto"), Affine{}, material}}, "auto",
                          {.max_depth = 12, .next_event = false});
    Pixels pixels = render(*scene, 512);
    double mean = 0.0, square = 0.0, exact = (1.0 - std::pow(a, 12)) / (1.0 - a);
    for (size_t i = 0; i < pixels.mean.size(); ++i) {
      mean += pixels.mean[i] / pixels.mean.size();
      square += pixels.error[i] * pixels.error[i] / (pixels.mean.size() * pixels.mean.size());
    }
    EXPECT_GT(square, 0.0);  // it took part
    EXPECT_NEAR(mean, exact, 5.0 * std::sqrt(square)) << a;
  }
}

TEST(Whitted, FollowsCoatsAndBlendsWithoutNoise) {
  using enum MaterialKind;
  SceneBuilder builder;
  builder.set_camera(Camera(Vec3(0, 0, 5), Vec3(0), Vec3(0, 1, 0), 0.001, 1, 1));
  builder.set_background(Rgb(1.0));
  int mirror = builder.add_material({.kind = Mirror, .reflectance = Rgb(0.5)});
  int plastic = builder.add_material({.kind = Plastic, .reflectance = Rgb(1.0), .ior = 1.5});
  int glass = builder.add_material({.kind = Dielectric, .ior = 1.5});
  Material blend{.kind = Blend, .parts = {mirror, plastic, glass}, .shares = {0.5, 0.25, 0.25}};
  uint32_t plate = builder.add_solid(Block{Vec3(-1, -1, -0.1), Vec3(1, 1, 0.1)});
  auto scene = scene_of(builder, {{plate, Affine{}, builder.add_material(blend)}}, "auto",
                        {.integrator = Integrator::Whitted, .max_depth = 2});
  const double r = 0.04;  // of an index of 1.5, straight on; what gets in is cut off by the depth
  ChunkSums chunk = render_chunk(*scene, {0, 0, 1, 1}, 0, 2);
  EXPECT_NEAR(chunk.sums[0], 0.5 * 0.5 + 0.25 * r + 0.25 * r, 1e-9);
  EXPECT_EQ(chunk.sums[0], chunk.sums[3]);
}

}  // namespace
}  // namespace tilecast
