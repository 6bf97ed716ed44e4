// The choice of one light among many: probabilities that are what they say, no light left out, less variance than by power.
#include <gtest/gtest.h>

#include <random>

#include "estimates.h"
#include "integrators/direct.h"
#include "stress/scenes.h"

namespace tilecast {
namespace {

using namespace stress;

// Points, spots, balls and rectangles strewn about a floor, dim and bright ones, some at one place.
std::shared_ptr<const Scene> strewn(int count, uint64_t seed) {
  SceneBuilder builder;
  Random random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<InstanceSource> list;
  uint32_t square = builder.add_rectangle(0.2, 0.3), ball = builder.add_solid(Sphere{0.1});
  Vec3 place(0.0);
  for (int i = 0; i < count; ++i) {
    if (i % 7) place = Vec3(20 * unit(random) - 10, 0.2 + 2 * unit(random), 20 * unit(random) - 10);
    const Rgb colour(std::pow(10.0, 3 * unit(random)));
    const int lamp = builder.add_material({.reflectance = Rgb(0.0), .emission = colour});
    switch (random() % 4) {
      case 0: builder.add_point_light({place, colour}); break;
      case 1: {
        const double outer = 2 * unit(random) - 1;
        builder.add_spot_light({place, random_direction(random), colour, outer + (1 - outer) * unit(random), outer});
        break;
      }
      case 2: list.push_back({square, translate(place) * rotate(6 * unit(random), random_direction(random)), lamp}); break;
      default: list.push_back({ball, translate(place), lamp});
    }
  }
  list.push_back({builder.add_rectangle(20, 20), Affine{}});
  return scene_of(builder, list);
}

LitPlace place_on_floor(Random& random) {
  std::uniform_real_distribution<double> unit(-10, 10);
  return {Vec3(unit(random), 0.0, unit(random)), Vec3(0, 1, 0)};
}

TEST(LightTree, ChoosesWithItsProbabilities) {
  auto scene = strewn(200, 1);
  const Lights& lights = scene->lights;
  ASSERT_TRUE(lights.has_tree());
  Random random(4);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int k = 0; k < 12; ++k) {
    LitPlace place = place_on_floor(random);
    if (k % 3 == 0) place.normal = Vec3(0.0);
    constexpr int kSamples = 40'000;
    std::vector<double> counts(lights.count() + 1), expected(lights.count() + 1);  // the last: none at all
    double sum = 0.0;
    for (size_t i = 0; i < lights.count(); ++i) sum += expected[i] = lights.probability(i, place);
    EXPECT_LT(sum, 1.0 + 1e-12);
    EXPECT_GT(sum, 0.5);  // bounds on many lights are wider than those on each
    expected.back() = std::max(0.0, 1.0 - sum);
    for (double& e : expected) e = e < 1e-12 ? 0.0 : e * kSamples;
    for (int i = 0; i < kSamples; ++i) {
      const LightChoice choice = lights.choose(unit(random), place);
      ++counts[choice.probability > 0.0 ? choice.light : lights.count()];
      if (choice.probability > 0.0) {
        ASSERT_NEAR(choice.probability, lights.probability(choice.light, place), 1e-14);
      }
    }
    expect_distributed(counts, expected);
  }
}

// What light i brings to a floor at a place, by its own samples alone, blockers left out.
double brought(const Scene& scene, const LitPlace& place, size_t light, Sampler& sampler) {
  Surface surface{};
  surface.point = place.point, surface.normal = place.normal;
  const DirectLight direct = sample_direct(scene, surface, {light, 1.0}, sampler);
  return direct.radiance.x * std::max(0.0, direct.direction.y);
}

TEST(LightTree, LeavesOutNoLightThatReachesThePlace) {
  Random random(8);
  for (uint64_t seed : {2, 3}) {
    auto scene = strewn(300, seed);
    for (int k = 0; k < 100; ++k) {
      const LitPlace place = place_on_floor(random);
      Sampler sampler(k, 0, 0, 0);
      for (size_t i = 0; i < scene->lights.count(); ++i)
        if (brought(*scene, place, i, sampler) > 0.0) {
          ASSERT_GT(scene->lights.probability(i, place), 0.0) << i;
        }
    }
  }
}

// One light chosen by the tree gives the sum over all lights on average; its variance, worked out from the probabilities,
// is a small part of that of a choice by power.
TEST(LightTree, IsUnbiasedAndVariesLessThanPower) {
  auto scene = strewn(1000, 6);
  const Lights& lights = scene->lights;
  Random random(8);
  std::uniform_real_distribution<double> unit(0, 1);
  double of_tree = 0.0, of_power = 0.0;
  for (int k = 0; k < 16; ++k) {
    const LitPlace place = place_on_floor(random);
    Sampler sampler(k, 1, 0, 0);
    std::vector<double> value(lights.count()), power(lights.count());
    double exact = 0.0, all = 0.0, tree = 0.0, plain = 0.0;
    for (size_t i = 0; i < lights.count(); ++i) {
      exact += value[i] = brought(*scene, place, i, sampler);
      if (i < lights.first_spot()) power[i] = 4 * kPi * lights.points[i].intensity.x;
      else if (i < lights.first_area()) power[i] = 2 * kPi * lights.spots[i - lights.first_spot()].intensity.x;
      else power[i] = kPi * lights.areas[i - lights.first_area()].area() * lights.areas[i - lights.first_area()].radiance.x;
      all += power[i];
    }
    for (size_t i = 0; i < lights.count(); ++i)
      if (value[i] > 0.0) {
        tree += value[i] * value[i] / lights.probability(i, place);
        plain += value[i] * value[i] * all / power[i];
      }
    of_tree += tree / (exact * exact) - 1, of_power += plain / (exact * exact) - 1;
    constexpr int kSamples = 20'000;
    double sum = 0.0;
    for (int i = 0; i < kSamples; ++i) {
      const LightChoice choice = lights.choose(unit(random), place);
      if (choice.probability > 0.0) sum += value[choice.light] / choice.probability;
    }
    EXPECT_NEAR(sum / kSamples, exact, 4.5 * std::sqrt((tree - exact * exact) / kSamples));
  }
  EXPECT_LT(of_tree, 0.1 * of_power);
}

TEST(LightTree, IsThereForManyLightsOnly) {
  EXPECT_FALSE(strewn(4, 1)->lights.has_tree());
  EXPECT_TRUE(strewn(5, 1)->lights.has_tree());
}

TEST(LightTree, TakesDistantLightsAsOftenAsAllOthersTogether) {
  SceneBuilder builder;
  for (int i = 0; i < 6; ++i) builder.add_point_light({Vec3(i, 1, 0), Rgb(1.0)});
  builder.add_directional_light({Vec3(0, -1, 0), Rgb(1.0)});
  builder.set_environment(Environment(std::vector<Vec3f>(2, Vec3f(1.0f)), 2, 1, 0.0));
  auto scene = scene_of(builder, {{builder.add_rectangle(20, 20), Affine{}}});
  const LitPlace place{Vec3(0.0), Vec3(0, 1, 0)};
  double near = 0.0;
  for (size_t i = 0; i < 6; ++i) near += scene->lights.probability(i, place);
  for (double p : {near, scene->lights.probability(6, place), scene->lights.probability(7, place)}) EXPECT_NEAR(p, 1.0 / 3, 1e-14);
  for (double u : {0.0, 0.32, 0.34, 0.66, 0.67, 1 - 0x1p-32}) {
    const LightChoice choice = scene->lights.choose(u, place);
    EXPECT_EQ(std::min<size_t>(choice.light, 7), u < 1.0 / 3 ? choice.light : u < 2.0 / 3 ? 6 : 7);
    EXPECT_NEAR(choice.probability, scene->lights.probability(choice.light, place), 1e-15);
  }
}

// A thousand lights at one place, and in one line: no split tells them apart, and depth stays bounded.
TEST(LightTree, StandsLightsThatCannotBeSplit) {
  for (double step : {0.0, 1e-3}) {
    SceneBuilder builder;
    for (int i = 0; i < 1000; ++i) builder.add_point_light({Vec3(step * i * i, 1, 0), Rgb(i + 1.0)});
    auto scene = scene_of(builder, {{builder.add_rectangle(20, 20), Affine{}}});
    double sum = 0.0;
    for (size_t i = 0; i < 1000; ++i) {
      const double p = scene->lights.probability(i, {Vec3(0.0), Vec3(0, 1, 0)});
      EXPECT_GT(p, 0.0);
      sum += p;
    }
    EXPECT_NEAR(sum, 1.0, 1e-12);
  }
}

}  // namespace
}  // namespace tilecast
