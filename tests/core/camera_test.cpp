// Cameras and pixel filters against closed forms.
#include <gtest/gtest.h>

#include "estimates.h"
#include "stress/scenes.h"

namespace tilecast {
namespace {

using namespace stress;

const View kView{Vec3(1, 2, 5), Vec3(1, 2, 0), Vec3(0, 3, 0), 4, 2};  // looks along -z

void expect_close(const Vec3& a, const Vec3& b) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], 1e-14) << i;
}

TEST(Camera, APinholeSeesThroughEachImagePoint) {
  Camera camera = Camera::perspective(kView, 90.0);  // pixels have a side of 1 at a distance of 1
  for (Vec2 p : {Vec2(2, 1), Vec2(0, 0), Vec2(3.25, 1.75)}) {
    Ray ray = camera.ray(p.x, p.y);
    EXPECT_EQ(ray.origin, kView.position);
    expect_close(ray.direction, glm::normalize(Vec3(p.x - 2, 1 - p.y, -1)));
  }
}

TEST(Camera, OrthographicRaysAreParallel) {
  Camera camera = Camera::orthographic(kView, 6.0);  // 3 metres a pixel
  EXPECT_TRUE(camera.has_extent());
  for (Vec2 p : {Vec2(2, 1), Vec2(0, 0), Vec2(3.25, 1.75)}) {
    Ray ray = camera.ray(p.x, p.y);
    expect_close(ray.origin, kView.position + 3.0 * Vec3(p.x - 2, 1 - p.y, 0));
    expect_close(ray.direction, Vec3(0, 0, -1));
  }
}

TEST(Camera, FindsTheImagePointsOfWhatItSees) {
  for (const Camera& camera : {Camera::perspective(kView, 50.0), Camera::orthographic(kView, 6.0)})
    for (Vec2 p : {Vec2(2, 1), Vec2(0, 0), Vec2(3.25, 1.75), Vec2(-7, 20)})
      for (double t : {1e-3, 1.0, 1e3}) {
        Vec2 found;
        ASSERT_TRUE(camera.image_point(camera.ray(p.x, p.y).at(t), found));
        EXPECT_NEAR(found.x, p.x, 1e-9);
        EXPECT_NEAR(found.y, p.y, 1e-9);
        EXPECT_FALSE(camera.image_point(camera.ray(p.x, p.y).at(-t), found));
      }
  Vec2 ignored;
  EXPECT_FALSE(Camera::panorama(kView).image_point(Vec3(0), ignored));
  EXPECT_FALSE(Camera::thin_lens(kView, 50.0, 0.1, 3.0).image_point(Vec3(0), ignored));
}

// At a distance d the rays of one image point fill a disk of radius aperture |d - f| / f: the circle of confusion.
TEST(Camera, ALensBlursWhatIsOutOfFocus) {
  const double aperture = 0.25, focus = 4.0;
  Camera camera = Camera::thin_lens(kView, 90.0, aperture, focus), pinhole = Camera::perspective(kView, 90.0);
  for (double distance : {4.0, 1.0, 9.0})
    for (double turn : {0.0, 0.125, 0.7}) {
      const Vec2 rim(std::cos(2 * kPi * turn), std::sin(2 * kPi * turn));
      Ray ray = camera.ray(3.5, 0.25, rim), middle = pinhole.ray(3.5, 0.25);
      EXPECT_NEAR(glm::length(ray.direction), 1.0, 1e-15);
      const Vec3 at = ray.at((5.0 - distance - ray.origin.z) / ray.direction.z), centre = middle.at(distance / -middle.direction.z);
      EXPECT_NEAR(glm::length(at - centre), aperture * std::fabs(distance - focus) / focus, 1e-14);
    }
}

TEST(Camera, APanoramaSeesAllDirections) {
  Camera camera = Camera::panorama(kView);
  expect_close(camera.ray(2, 1).direction, Vec3(0, 0, -1));
  expect_close(camera.ray(3, 1).direction, Vec3(1, 0, 0));
  expect_close(camera.ray(1, 1).direction, Vec3(-1, 0, 0));
  expect_close(camera.ray(4, 1).direction, Vec3(0, 0, 1));
  expect_close(camera.ray(0.3, 0).direction, Vec3(0, 1, 0));
  expect_close(camera.ray(0.3, 2).direction, Vec3(0, -1, 0));
  const double h = std::sqrt(0.5);
  expect_close(camera.ray(2, 0.5).direction, Vec3(0, h, -h));
}

TEST(Camera, RefusesWhatSeesNothing) {
  View same = kView, flat = kView;
  same.target = same.position;
  flat.up = Vec3(0, 0, 2);
  EXPECT_THROW(Camera::panorama(same), Error);
  EXPECT_THROW(Camera::panorama(flat), Error);
  EXPECT_THROW(Camera::perspective(kView, 180.0), Error);
  EXPECT_THROW(Camera::orthographic(kView, 0.0), Error);
  EXPECT_THROW(Camera::thin_lens(kView, 40.0, -1.0, 1.0), Error);
  EXPECT_THROW(Camera::thin_lens(kView, 40.0, 1.0, 0.0), Error);
}

// An orthographic camera whose rays start half in tinted glass, half beside it: each is weakened by what it has left.
TEST(Camera, RaysThatStartInsideOfGlassAreInsideOfIt) {
  for (bool lens : {false, true}) {
    SceneBuilder builder;
    builder.set_background(Rgb(1.0));
    int tinted = builder.add_material({.kind = MaterialKind::Dielectric, .ior = 1.0, .absorption = Rgb(2.0)});
    uint32_t half = builder.add_solid(Block{Vec3(0, -9, -3), Vec3(9, 9, 9)});
    const View view{Vec3(0), Vec3(0, 0, -1), Vec3(0, 1, 0), 64, 1};
    builder.set_camera(lens ? Camera::thin_lens(view, 1e-6, 1.0, 1e9) : Camera::orthographic(view, 1.0 / 64));
    auto scene = scene_of(builder, {{half, Affine{}, tinted}});
    expect_near(estimate(*scene, 256), 0.5 + 0.5 * std::exp(-6.0));
  }
}

// --- Filters: integrals over a grid of samples, against quadrature of formulas written down again.

double formula(PixelFilter::Kind kind, double x) {
  x = std::fabs(x);
  switch (kind) {
    case PixelFilter::Kind::Box: return x < 0.5;
    case PixelFilter::Kind::Tent: return std::max(0.0, 1.0 - x);
    case PixelFilter::Kind::Gaussian: return std::max(0.0, std::exp(-2.0 * x * x) - std::exp(-8.0));
    case PixelFilter::Kind::BlackmanHarris: {
      const double a = kPi * (x / 1.5 + 1.0);
      return x < 1.5 ? 0.35875 - 0.48829 * std::cos(a) + 0.14128 * std::cos(2 * a) - 0.01168 * std::cos(3 * a) : 0.0;
    }
    default: {
      const double b = 1.0 / 3.0, c = 1.0 / 3.0;
      if (x < 1) return ((12 - 9 * b - 6 * c) * x * x * x + (-18 + 12 * b + 6 * c) * x * x + (6 - 2 * b)) / 6;
      if (x < 2) return ((-b - 6 * c) * x * x * x + (6 * b + 30 * c) * x * x + (-12 * b - 48 * c) * x + (8 * b + 24 * c)) / 6;
      return 0.0;
    }
  }
}

// The integral of f(x) g(x) over that of f.
template <class G>
double filtered(PixelFilter::Kind kind, G&& g) {
  double sum = 0.0, all = 0.0;
  constexpr int kSteps = 400'000;
  for (int i = 0; i < kSteps; ++i) {
    const double x = (i + 0.5) / kSteps * 4.0 - 2.0, f = formula(kind, x);
    sum += f * g(x), all += f;
  }
  return sum / all;
}

TEST(PixelFilter, ConvolvesByTheFilter) {
  for (int k = 0; k < static_cast<int>(std::size(kFilterNames)); ++k) {
    const PixelFilter::Kind kind = static_cast<PixelFilter::Kind>(k);
    const PixelFilter filter(kind);
    constexpr int kSide = 1024;
    double weights = 0.0, ramp = 0.0, square = 0.0, edge = 0.0, wave = 0.0;
    for (int i = 0; i < kSide; ++i)
      for (int j = 0; j < kSide; ++j) {
        double weight = 1.0;
        const Vec2 p = filter.sample({(i + 0.5) / kSide, (j + 0.5) / kSide}, weight) - 0.5;
        ASSERT_LE(std::fabs(p.x), PixelFilter::radius(kind));
        if (kind != PixelFilter::Kind::Mitchell) {
          ASSERT_EQ(weight, 1.0);
        }
        weights += weight;
        ramp += weight * (3.0 * p.x - 2.0 * p.y);
        square += weight * p.x * p.x;
        edge += weight * (p.x < 0.3);
        wave += weight * std::cos(2.0 * p.y);
      }
    const double n = double(kSide) * kSide, room = 4.0 / kSide;  // a jump of the weight falls into one row of the grid
    EXPECT_NEAR(weights / n, 1.0, room) << kFilterNames[k];
    EXPECT_NEAR(ramp / n, 0.0, 1e-12) << kFilterNames[k];
    EXPECT_NEAR(square / n, filtered(kind, [](double x) { return x * x; }), room) << kFilterNames[k];
    EXPECT_NEAR(edge / n, filtered(kind, [](double x) { return double(x < 0.3); }), room) << kFilterNames[k];
    EXPECT_NEAR(wave / n, filtered(kind, [](double x) { return std::cos(2.0 * x); }), room) << kFilterNames[k];
  }
}

// A black wall ends at x = 0: in the pixel whose middle is 1/4 to the right of it, the filter sees what lies below -1/4.
TEST(PixelFilter, SmoothsAnEdgeInAnImage) {
  for (int k = 0; k < static_cast<int>(std::size(kFilterNames)); ++k) {
    SceneBuilder builder;
    builder.set_background(Rgb(1.0));
    int black = builder.add_material({.reflectance = Rgb(0.0)});
    uint32_t wall = builder.add_rectangle(100, 100);
    builder.set_camera(Camera::orthographic({Vec3(0.25, 0, 5), Vec3(0.25, 0, 0), Vec3(0, 1, 0), 1, 1}, 1.0));
    builder.set_filter(static_cast<PixelFilter::Kind>(k));
    auto scene = scene_of(builder, {{wall, translate(Vec3(50, 0, 0)) * rotate(kPi / 2, Vec3(1, 0, 0)), black}});
    ChunkSums chunk = render_chunk(*scene, {0, 0, 1, 1}, 0, 1 << 14);
    const double exact = filtered(static_cast<PixelFilter::Kind>(k), [](double x) { return double(x < -0.25); });
    EXPECT_NEAR((chunk.sums[0] + chunk.sums[3]) / (1 << 14), exact, 2e-3) << kFilterNames[k];
  }
}

}  // namespace
}  // namespace tilecast
