// Environments: looked up, sampled and made from a sky.
#include <gtest/gtest.h>

#include <random>

#include "estimates.h"
#include "scene/sky.h"
#include "stress/scenes.h"

namespace tilecast {
namespace {

using namespace stress;

constexpr int kWidth = 16, kHeight = 8;

// Bright pixels, black rows and colours.
std::vector<Vec3f> speckled() {
  Random random(5);
  std::uniform_real_distribution<float> unit(0, 1);
  std::vector<Vec3f> pixels(kWidth * kHeight);
  for (int i = 0; i < kWidth * kHeight; ++i)
    if (i / kWidth < 5) pixels[i] = unit(random) < 0.3f ? Vec3f(unit(random), unit(random), unit(random)) : Vec3f(0.0f);
  pixels[2 * kWidth + 3] = Vec3f(50.0f, 40.0f, 30.0f);
  return pixels;
}

Vec3 towards(double across, double down) {  // in shares of the image
  const double a = 2 * kPi * (across - 0.5), b = kPi * down;
  return {std::sin(b) * std::sin(a), std::cos(b), -std::sin(b) * std::cos(a)};
}

TEST(Environment, ShowsThePixelThatLiesInADirection) {
  for (double rotation : {0.0, 45.0, -500.0}) {
    const std::vector<Vec3f> pixels = speckled();
    Environment environment(pixels, kWidth, kHeight, rotation);
    const Affine turn = rotate(rotation * kPi / 180, Vec3(0, 1, 0));
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const Rgb found = environment.radiance(turn.vector(towards((x + 0.5) / kWidth, (y + 0.5) / kHeight)));
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], pixels[y * kWidth + x][c], 1e-10);
      }
    const Rgb between = environment.radiance(turn.vector(towards(0.0, 2.5 / kHeight)));
    EXPECT_NEAR(between.x, 0.5 * (pixels[2 * kWidth].x + pixels[3 * kWidth - 1].x), 1e-10);
  }
}

TEST(Environment, IsWhatAPanoramaSees) {
  SceneBuilder builder;
  builder.set_environment(Environment(speckled(), kWidth, kHeight, 0.0));
  Camera camera = Camera::panorama({Vec3(7, 8, 9), Vec3(7, 8, 0), Vec3(0, 1, 0), kWidth, kHeight});
  builder.set_camera(camera);
  auto scene = scene_of(builder, {});
  EXPECT_EQ(std::count(scene->features.begin(), scene->features.end(), "environment"), 1);
  const Environment& environment = *scene->lights.environment;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(environment.radiance(camera.ray(x + 0.5, y + 0.5).direction)[c], speckled()[y * kWidth + x][c], 1e-10);
}

// Counts of sampled directions over a grid finer than the pixels, against the density integrated over its cells; all at once
// a test of the density, which must be constant over a pixel's solid angle, and of its integral.
TEST(Environment, IsSampledWithItsDensity) {
  constexpr int kFine = 2, kSamples = 1'000'000;
  for (double rotation : {0.0, 77.0}) {
    Environment environment(speckled(), kWidth, kHeight, rotation);
    const Affine back = rotate(-rotation * kPi / 180, Vec3(0, 1, 0));
    std::vector<double> counts(kWidth * kHeight * kFine * kFine), expected = counts;
    Random random(9);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < kSamples; ++i) {
      const Environment::Sample found = environment.sample({unit(random), unit(random)});
      ASSERT_GT(found.pdf, 0.0);
      ASSERT_NEAR(glm::length(found.direction), 1.0, 1e-14);
      if (i % 64 == 0) {
        ASSERT_NEAR(environment.pdf(found.direction) / found.pdf, 1.0, 1e-12);
      }
      const Vec3 d = back.vector(found.direction);
      const double across = std::atan2(d.x, -d.z) / (2 * kPi) + 0.5, down = std::acos(std::clamp(d.y, -1.0, 1.0)) / kPi;
      const int x = std::min(kWidth * kFine - 1, static_cast<int>(across * kWidth * kFine));
      const int y = std::min(kHeight * kFine - 1, static_cast<int>(down * kHeight * kFine));
      ++counts[y * kWidth * kFine + x];
    }
    double all = 0.0;
    const Affine turn = rotate(rotation * kPi / 180, Vec3(0, 1, 0));
    for (int y = 0; y < kHeight * kFine; ++y)
      for (int x = 0; x < kWidth * kFine; ++x) {
        const double solid = 2 * kPi / (kWidth * kFine) *
                             (std::cos(kPi * y / (kHeight * kFine)) - std::cos(kPi * (y + 1) / (kHeight * kFine)));
        const Vec3 middle = turn.vector(towards((x + 0.5) / (kWidth * kFine), (y + 0.5) / (kHeight * kFine)));
        all += expected[y * kWidth * kFine + x] = kSamples * solid * environment.pdf(middle);
      }
    EXPECT_NEAR(all, kSamples, 1e-6);
    expect_distributed(counts, expected);
  }
}

// Wherever there is radiance there is density, however small: between a bright pixel and its black neighbours.
TEST(Environment, CanSampleAllThatIsNotBlack) {
  Environment environment(speckled(), kWidth, kHeight, 0.0);
  Random random(3);
  for (int i = 0; i < 20'000; ++i) {
    const Vec3 d = random_direction(random);
    if (max_component(environment.radiance(d)) > 0.0) {
      ASSERT_GT(environment.pdf(d), 0.0);
    }
  }
}

TEST(Environment, OfZerosIsNoLight) {
  SceneBuilder builder;
  builder.set_background(Rgb(1.0));
  builder.set_environment(Environment(std::vector<Vec3f>(8, Vec3f(-1.0f)), 4, 2, 0.0));
  builder.set_camera(Camera(Vec3(0, 1, 4), Vec3(0), Vec3(0, 1, 0), 60, 8, 8));
  auto scene = scene_of(builder, {{builder.add_rectangle(2, 2), Affine{}}});
  EXPECT_EQ(scene->lights.count(), 0u);
  for (double value : render_chunk(*scene, {0, 0, 8, 8}, 0, 16).sums) EXPECT_EQ(value, 0.0);
}

TEST(Environment, RefusesWhatIsNoRadiance) {
  for (float bad : {std::nanf(""), HUGE_VALF, -HUGE_VALF, 2e30f}) {
    std::vector<Vec3f> pixels(8, Vec3f(1.0f));
    pixels[6].y = bad;
    try {
      Environment environment(pixels, 4, 2, 0.0);
      ADD_FAILURE() << bad;
    } catch (const Error& error) {
      EXPECT_EQ(std::string(error.what()).find("pixel (2, 1) is "), 0u) << error.what();
    }
  }
  EXPECT_THROW(Environment({}, 0, 0, 0.0), Error);
  EXPECT_THROW(Environment(std::vector<Vec3f>(3), 2, 2, 0.0), Error);
}

TEST(Environment, OfOneColourIsTheBackground) {
  for (MaterialKind kind : {MaterialKind::Diffuse, MaterialKind::Conductor}) {
    SceneBuilder builder;
    builder.set_camera(Camera(Vec3(0, 1, 4), Vec3(0), Vec3(0, 1, 0), 40, 16, 16));
    int material = builder.add_material({.kind = kind, .reflectance = Rgb(0.7), .roughness = 0.5});
    uint32_t floor = builder.add_rectangle(6, 6), block = builder.add_solid(Block{Vec3(-0.5), Vec3(0.5)});
    const std::vector<InstanceSource> list{{floor, Affine{}, material}, {block, translate(Vec3(0, 0.6, 0)), material}};
    SceneBuilder other = builder;
    builder.set_background(Rgb(2.0));
    other.set_environment(Environment(std::vector<Vec3f>(32, Vec3f(2.0f)), 8, 4, 0.0));
    auto plain = scene_of(builder, list), image = scene_of(other, list);
    // Pixels differ much more than samples of one do: their difference is what varies by chance.
    ChunkSums a = render_chunk(*plain, {0, 0, 16, 16}, 0, 256), b = render_chunk(*image, {0, 0, 16, 16}, 0, 256);
    double sum = 0.0, squares = 0.0, n = 0.0;
    for (size_t i = 0; i < a.sums.size(); i += 3) {
      const double difference = (a.sums[i] - b.sums[i]) / 128.0;
      sum += difference, squares += difference * difference, ++n;
    }
    expect_near({sum / n, std::sqrt(squares) / n}, 0.0);
  }
}

// --- The sky

double luminance(const Rgb& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

TEST(Sky, IsBrightAboutTheSunAndTheSameOnBothSidesOfIt) {
  Sky sky;
  sky.sun = Vec3(0, 2, -2);
  Environment environment = make_environment(sky);
  const Vec3 sun = glm::normalize(sky.sun);
  Random random(1);
  double brightest = luminance(environment.radiance(sun));
  for (int i = 0; i < 2000; ++i) {
    Vec3 d = random_direction(random);
    d.y = std::fabs(d.y);
    const Rgb here = environment.radiance(d), there = environment.radiance({-d.x, d.y, d.z});
    EXPECT_LE(luminance(here), brightest * 1.01);
    EXPECT_NEAR(luminance(here), luminance(there), 1e-5 * brightest);
    EXPECT_GT(std::min({here.x, here.y, here.z}), 0.0);
  }
  const Rgb away = environment.radiance(glm::normalize(Vec3(0, 1, 1)));
  EXPECT_GT(away.z, away.x);  // blue
}

// Table 2 of the paper's appendix, worked out by hand for a turbidity of 2 and the sun in the zenith:
// Y = (4.0453 T - 4.9710) tan((4/9 - T/120) pi) - 0.2155 T + 2.4192, in 1,000 cd/m^2.
TEST(Sky, HasThePapersLuminanceInTheZenith) {
  Sky sky;
  sky.turbidity = 2.0, sky.scale = 1.0;
  const double exact = (4.0453 * 2 - 4.9710) * std::tan((4.0 / 9 - 2.0 / 120) * kPi) - 0.2155 * 2 + 2.4192;
  EXPECT_NEAR(luminance(make_environment(sky).radiance(Vec3(0, 1, 0))), exact, 0.02 * exact);
}

TEST(Sky, LightsTheGround) {
  Sky sky;
  sky.sun = Vec3(1, 1, 0);
  sky.ground = Rgb(0.5);
  Environment environment = make_environment(sky);
  double irradiance = 0.0;
  constexpr int kSteps = 400;
  for (int i = 0; i < kSteps; ++i)  // uniform in the squared sine
    for (int j = 0; j < kSteps; ++j) {
      const double s2 = (i + 0.5) / kSteps, a = 2 * kPi * (j + 0.5) / kSteps;
      irradiance += environment.radiance({std::sqrt(s2) * std::cos(a), std::sqrt(1 - s2), std::sqrt(s2) * std::sin(a)}).y;
    }
  irradiance *= kPi / (kSteps * kSteps);
  EXPECT_NEAR(environment.radiance(Vec3(0, -1, 0)).y, 0.5 * irradiance / kPi, 2e-3 * irradiance);
}

TEST(Sky, RefusesWhatIsOutOfRange) {
  EXPECT_THROW(make_environment({.sun = Vec3(1, -0.1, 0)}), Error);
  EXPECT_THROW(make_environment({.sun = Vec3(0)}), Error);
  EXPECT_THROW(make_environment({.turbidity = 1.0}), Error);
  EXPECT_THROW(make_environment({.scale = -1.0}), Error);
}

}  // namespace
}  // namespace tilecast
