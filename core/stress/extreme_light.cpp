// Extreme scenes whose hazard is light. A sample that is not finite makes render_chunk throw, and the case with it.
#include <array>

#include "render/chunk.h"
#include "stress/scenes.h"
#include "stress/stress.h"

namespace tilecast::stress {
namespace {

Rgb sample(const Scene& scene, const Ray& ray, const Media& media, uint64_t i, RayCounts& counts) {
  Tracing tracing;
  Sampler sampler(static_cast<uint32_t>(i % 977), static_cast<uint32_t>(i / 977), static_cast<uint32_t>(i), 1);
  Rgb value = radiance(scene, ray, media, sampler, tracing);
  counts = tracing.counts;
  if (!is_finite(value)) throw SampleError("sample " + std::to_string(i) + " is not finite");
  return value;
}

// --- Two mirrors that are parallel but for 1e-6 rad, and a ray between them: 10,000 segments, none gets out.

double escapes_from_mirrors(Random& random, uint64_t i) {
  static constexpr int kDepth = 10'000;
  static const std::shared_ptr<const Scene> scene = [] {
    SceneBuilder builder;
    int mirror = builder.add_material({MaterialKind::Mirror, Rgb(1.0)});
    uint32_t sheet = builder.add_rectangle(1e4, 1e4);
    builder.set_background(Rgb(1.0));
    SceneBuilder::Options options;
    options.max_depth = kDepth;
    return scene_of(builder, {{sheet, Affine{}, mirror}, {sheet, translate(Vec3(0, 1, 0)) * rotate(1e-6, Vec3(0, 0, 1)), mirror}},
                    "auto", options);
  }();
  std::uniform_real_distribution<double> unit(-1, 1);
  // Up to 0.1 sideways a segment, and 1e-6 rad more with each bounce: less than 2,000 metres in all.
  Ray ray{Vec3(unit(random), 0.5, unit(random)), glm::normalize(Vec3(0.1 * unit(random), 1.0, 0.1 * unit(random)))};
  RayCounts counts;
  Rgb value = sample(*scene, ray, Media(), i, counts);
  return value != Rgb(0.0) || counts.bounce != kDepth - 1;
}

// --- A furnace: a glass ball in uniform light is as bright as the light, whatever its index of refraction. Errors of a
// sample are those of its weights, which grow with its segments.

double furnace_error(Random& random, uint64_t i) {
  static constexpr double kRatios[] = {1.0 + 1e-6, 1.0 - 1e-6, 1e-3, 1e3, 1.5};
  static constexpr int kDepth = 20'000;  // at an index of 1,000 all but 0.4% is reflected, at each segment
  static const std::vector<std::shared_ptr<const Scene>> scenes = [] {
    std::vector<std::shared_ptr<const Scene>> out;
    for (double ratio : kRatios) {
      SceneBuilder builder;
      Material glass;
      glass.kind = MaterialKind::Dielectric;
      glass.ior = ratio;
      int material = builder.add_material(glass);
      uint32_t sphere = builder.add_solid(Sphere{1.0});
      builder.set_background(Rgb(1.0));
      SceneBuilder::Options options;
      options.max_depth = kDepth;
      out.push_back(scene_of(builder, {{sphere, Affine{}, material}}, "auto", options));
    }
    return out;
  }();
  const Scene& scene = *scenes[i % std::size(kRatios)];
  RayCounts counts;
  Ray ray = random_ray(random, 3.0);
  ray.direction = glm::normalize(ray.direction);
  double value = sample(scene, ray, Media(), i, counts).x;
  return std::fabs(value - 1.0) / (8 * kUnitRoundoff * (counts.bounce + 1));
}

// --- The caustic below a glass ball of radius 1 under a disk of light: paths that start on a plane there, and find the
// light through the ball alone, against light that is traced the other way, from the disk through the ball to the plane.

constexpr double kIndex = 1.5, kDisk = 0.3, kAbove = 4.0, kBelow = 2.0, kRing = 0.05;
constexpr int kRings = 8;  // about the axis, kRing wide; the disk is hidden from them all by the ball

// A direction, uniform in the cone that the ball fills as seen from a point, and the cone's solid angle.
Vec3 towards_ball(const Vec3& from, double u, double v, double& solid_angle) {
  const double distance2 = glm::dot(from, from), widest = std::sqrt(1.0 - 1.0 / distance2);
  const double c = 1.0 - u * (1.0 - widest), s = std::sqrt(1.0 - c * c), turn = 2.0 * kPi * v;
  const Vec3 ahead = -from / std::sqrt(distance2), aside = glm::normalize(glm::cross(ahead, Vec3(0, 0, 1)));
  solid_angle = 2.0 * kPi * (1.0 - widest);
  return c * ahead + s * (std::cos(turn) * aside + std::sin(turn) * glm::cross(aside, ahead));
}

// Irradiance of the rings; the disk's radiance is 1. Every order of internal reflection that matters is followed.
std::array<double, kRings> irradiance_from_disk() {
  constexpr int kPoints = 1 << 21, kOrders = 12;
  std::array<double, kRings> power{};
  for (int i = 0; i < kPoints; ++i) {
    double u[3];  // Roberts' additive sequence in three dimensions
    for (int k = 0; k < 3; ++k) u[k] = std::fmod(0.5 + (i + 1) * std::pow(1.2207440846057596, -1.0 - k), 1.0);
    const Vec3 from(kDisk * std::sqrt(u[0]), kAbove, 0.0);
    double solid_angle;
    Vec3 way = towards_ball(from, u[1], u[2], solid_angle);
    const double weight = -way.y * solid_angle * kPi * kDisk * kDisk / kPoints;
    auto land = [&](const Vec3& start, const Vec3& along, double part) {
      if (along.y >= 0.0) return;
      const Vec3 at = start + (-kBelow - start.y) / along.y * along;
      const double ring = std::hypot(at.x, at.z) / kRing;
      if (ring < kRings) power[static_cast<int>(ring)] += weight * part;
    };
    const double b = glm::dot(from, way);
    Vec3 at = from + (-b - std::sqrt(std::max(0.0, b * b - glm::dot(from, from) + 1.0))) * way;
    const double cos_out = -glm::dot(at, way), cos_in = std::sqrt(1.0 - (1.0 - cos_out * cos_out) / (kIndex * kIndex));
    const double across = (cos_out - kIndex * cos_in) / (cos_out + kIndex * cos_in);
    const double along = (kIndex * cos_out - cos_in) / (kIndex * cos_out + cos_in);
    const double reflected = 0.5 * (across * across + along * along);  // the same at every meeting with the sphere
    land(at, way + 2.0 * cos_out * at, reflected);
    way = way / kIndex + (cos_out / kIndex - cos_in) * at;
    double part = 1.0 - reflected;
    for (int order = 0; order < kOrders; ++order, part *= reflected) {
      at += 2.0 * cos_in * way;  // a chord
      land(at, kIndex * way - (kIndex * cos_in - cos_out) * at, part * (1.0 - reflected));
      way -= 2.0 * cos_in * at;
    }
  }
  for (int ring = 0; ring < kRings; ++ring) power[ring] /= kPi * kRing * kRing * (2 * ring + 1);
  return power;
}

// How many standard errors the mean of 4,096 paths lies off.
double caustic_error(Random& random, uint64_t i) {
  constexpr int kPaths = 4096;
  static const std::array<double, kRings> exact = irradiance_from_disk();
  static const std::shared_ptr<const Scene> scene = [] {
    SceneBuilder builder;
    int glass = builder.add_material({.kind = MaterialKind::Dielectric, .ior = kIndex});
    int lamp = builder.add_material({.reflectance = Rgb(0.0), .emission = Rgb(1.0)});
    uint32_t ball = builder.add_solid(Sphere{1.0}), disk = builder.add_flat(Disk{kDisk});
    SceneBuilder::Options options;
    options.max_depth = 32;
    return scene_of(builder, {{ball, Affine{}, glass}, {disk, translate(Vec3(0, kAbove, 0)) * rotate(kPi, Vec3(1, 0, 0)), lamp}},
                    "auto", options);
  }();
  const int ring = static_cast<int>(i % kRings);
  double sum = 0.0, squares = 0.0;
  for (int k = 0; k < kPaths; ++k) {
    const double r = kRing * std::sqrt(ring * ring + uniform(random, 0, 1) * (2 * ring + 1)), angle = uniform(random, 0, 2 * kPi);
    const Vec3 from(r * std::cos(angle), -kBelow, r * std::sin(angle));
    double solid_angle;
    const Vec3 way = towards_ball(from, uniform(random, 0, 1), uniform(random, 0, 1), solid_angle);
    RayCounts counts;
    const double value = way.y * solid_angle * sample(*scene, {from, way}, Media(), i * kPaths + k, counts).x;
    sum += value;
    squares += value * value;
  }
  const double mean = sum / kPaths;
  return std::fabs(mean - exact[ring]) / std::sqrt((squares / kPaths - mean * mean) / (kPaths - 1));
}

// --- Lights that are hard to sample: of no area, and tiny but bright. Samples are finite and not negative.

enum class Lamp { Flat, Tiny };

std::shared_ptr<const Scene> lit_floor(Lamp kind, Integrator integrator) {
  SceneBuilder builder;
  int lamp = builder.add_material({MaterialKind::Diffuse, Rgb(0.0), -1, 0.0, 1.5, Rgb(0.0), Rgb(kind == Lamp::Flat ? 1.0 : 1e8)});
  int metal = builder.add_material({MaterialKind::Conductor, Rgb(0.9), -1, 0.2});
  int glass = builder.add_material({MaterialKind::Dielectric});
  uint32_t floor = builder.add_rectangle(10, 10), ball = builder.add_solid(Sphere{0.5});
  MeshSource source = icosphere(1).transformed(1e-4, Vec3(0, 2, 0));
  if (kind == Lamp::Flat) source = {{{-1, 2, 0}, {0, 2, 0}, {1, 2, 0}, {0, 2, 0}}, {{0, 1, 2}, {0, 2, 1}, {1, 3, 1}}};
  uint32_t light = builder.add_mesh(source.build(), "auto");
  builder.set_camera(Camera(Vec3(0, 1.5, 5), Vec3(0, 0.5, 0), Vec3(0, 1, 0), 45, 32, 32));
  SceneBuilder::Options options;
  options.integrator = integrator;
  return scene_of(builder, {{floor, Affine{}}, {ball, translate(Vec3(0.6, 0.5, 0)), metal},
                            {ball, translate(Vec3(-0.6, 0.5, 0)), glass},
                            {light, Affine{}, lamp}}, "auto", options);
}

// Values that a scene with such a light cannot have: black with the light of no area, lit with the other.
double wrong_values(uint64_t i, Lamp kind) {
  auto scene = lit_floor(kind, i % 2 ? Integrator::Whitted : Integrator::Path);
  constexpr uint32_t kSamples = 16;
  ChunkSums chunk = render_chunk(*scene, {0, 0, 32, 32}, static_cast<uint32_t>(i / 2) * kSamples, kSamples);
  double wrong = 0.0, sum = 0.0;
  for (double value : chunk.sums) {
    wrong += kind == Lamp::Flat ? value != 0.0 : !(value >= 0.0);
    sum += value;
  }
  return wrong + (kind == Lamp::Tiny && !(sum > 0.0));
}

}  // namespace

void add_extreme_light(std::vector<Case>& out) {
  out.push_back({"parallel-mirrors", 0, "rays that get out, 10,000 deep", 0, Combine::Sum, 512, 1'000'000,
                 sum_of(escapes_from_mirrors), 32});
  out.push_back({"glass-furnace", 0, "error of a sample, in 8 u for each segment", 1, Combine::Max, 20'000, 10'000'000,
                 worst_of(furnace_error), 256});
  out.push_back({"caustic", 0, "irradiance below a glass ball off that of light traced forwards, in standard errors", 6,
                 Combine::Max, 64, 100'000, worst_of(caustic_error), 4});
  out.push_back({"light-without-area", 0, "values that are not black", 0, Combine::Sum, 8, 20'000,
                 sum_of([](auto&, uint64_t i) { return wrong_values(i, Lamp::Flat); }), 1});
  out.push_back({"tiny-bright-light", 0, "values that are not finite or negative, or no light at all", 0, Combine::Sum, 8, 20'000,
                 sum_of([](auto&, uint64_t i) { return wrong_values(i, Lamp::Tiny); }), 1});
}

}  // namespace tilecast::stress
