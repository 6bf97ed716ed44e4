// What materials do with light: their sampling density is that of their samples, white ones give all of it back, and
// both ways through them weigh the same. At all angles, up to 89.9999 degrees.
#include "shading/bsdf.h"
#include "stress/chi_squared.h"
#include "stress/scenes.h"
#include "stress/stress.h"

namespace tilecast::stress {
namespace {

// A material, looked at from outside or from inside.
struct Specimen {
  std::shared_ptr<const Scene> scene;
  Surface surface;
  Boundary boundary;
  bool white;  // reflects and transmits all light

  Bsdf bsdf() const { return {*scene, surface, boundary}; }
};

// Of the parts, if there are any, in equal shares.
Specimen specimen(Material material, bool white, bool inside = false, const std::vector<Material>& parts = {}) {
  SceneBuilder builder;
  builder.add_texture(Gradient{Rgb(0.5), Rgb(0.5), 0, 0.0, 1.0});  // what a normal map is asked for is in the surface
  for (size_t i = 0; i < parts.size(); ++i) {
    material.parts[i] = builder.add_material(parts[i]);
    material.shares[i] = 1.0 / parts.size();
  }
  int handle = builder.add_material(material);
  Specimen out{scene_of(builder, {{builder.add_solid(Sphere{1.0}), Affine{}, handle}}), {}, {}, white};
  out.surface.normal = Vec3(0, 0, 1);
  out.surface.front = !inside;
  out.surface.material = &out.scene->materials[handle];
  if (out.surface.material->refracts) {
    double ior = out.surface.material->ior;
    out.boundary = {inside ? 1.0 / ior : ior, nullptr, !inside, true};
  }
  return out;
}

const std::vector<Specimen>& specimens() {
  static const std::vector<Specimen> all = [] {
    const Rgb white(1.0);
    using enum MaterialKind;
    std::vector<Specimen> out;
    out.push_back(specimen({.kind = Diffuse, .reflectance = white}, true));
    for (double roughness : {0.3, 1.0})
      out.push_back(specimen({.kind = Diffuse, .reflectance = white, .roughness = roughness}, true));
    for (double roughness : {0.0, 0.2, 0.5, 1.0}) {
      out.push_back(specimen({.kind = Conductor, .reflectance = white, .roughness = roughness}, true));
      out.push_back(specimen({.kind = Plastic, .reflectance = white, .roughness = roughness, .ior = 1.5}, true));
    }
    const Rgb eta(0.183, 0.421, 1.373), k(3.42, 2.35, 1.77);  // gold
    out.push_back(specimen({.kind = Conductor, .roughness = 0.4, .eta = eta, .k = k}, false));
    const std::pair<double, double> glasses[]{{0.0, 1.5}, {0.25, 1.5}, {0.7, 1.33}, {0.5, 1.05}};
    for (auto [roughness, ior] : glasses)
      for (bool inside : {false, true})
        out.push_back(specimen({.kind = Dielectric, .roughness = roughness, .ior = ior}, true, inside));
    const Rgb half(0.5);
    for (double exponent : {0.0, 3.0, 200.0})
      out.push_back(specimen({.kind = Phong, .reflectance = half, .specular = half, .exponent = exponent}, false));
    Material metal{.kind = Conductor, .reflectance = white, .roughness = 0.5};
    Material body{.kind = Plastic, .reflectance = white, .roughness = 0.5};
    Material glass{.kind = Dielectric, .roughness = 0.25}, mirror{.kind = Mirror, .reflectance = white};
    for (bool inside : {false, true}) out.push_back(specimen({.kind = Blend}, true, inside, {metal, glass, body}));
    out.push_back(specimen({.kind = Blend}, true, false, {body, mirror}));
    return out;
  }();
  return all;
}

// Some whose lobes stand about the normal of a map, so that light is lost below the horizon, and both ways differ.
const std::vector<Specimen>& tilted_specimens() {
  static const std::vector<Specimen> all = [] {
    using enum MaterialKind;
    std::vector<Specimen> out;
    for (double angle : {0.3, 1.2}) {
      auto add = [&](Material material, bool inside = false) {
        material.normal_map = 0;
        Specimen tilted = specimen(material, false, inside);
        tilted.surface.shading_normal = {std::sin(angle), 0.0, std::cos(angle)};
        out.push_back(tilted);
      };
      add({.kind = Diffuse, .reflectance = Rgb(1.0)});
      add({.kind = Conductor, .reflectance = Rgb(1.0), .roughness = 0.5});
      add({.kind = Plastic, .reflectance = Rgb(1.0), .roughness = 0.5, .ior = 1.5});
      for (bool inside : {false, true}) add({.kind = Dielectric, .roughness = 0.5, .ior = 1.5}, inside);
    }
    return out;
  }();
  return all;
}

Vec3 direction(double cosine, double turn) {
  double sine = std::sqrt((1.0 - cosine) * (1.0 + cosine));
  return {sine * std::cos(2 * kPi * turn), sine * std::sin(2 * kPi * turn), cosine};
}

// Every second one anywhere; the others from straight above to 89.9999 degrees.
Vec3 random_viewer(Random& random, uint64_t i) {
  static constexpr double kCosines[]{1.0, 0.9, 0.5, 0.1, 0.01, 1.7453292519943e-6};
  double turn = random() * 0x1p-64, any = 1.0 - random() * 0x1p-64;
  return direction(i & 1 ? any : kCosines[i / 2 % std::size(kCosines)], turn);
}

// The integral over a patch of directions, from one cosine to another and one turn to another, of a function that may
// have a narrow peak: Gauss and Legendre's rule of 4 x 4 points, in quarters of quarters where that makes a difference, and at first.
template <class Function>
double patch_integral(const Function& function, double c0, double c1, double t0, double t1, int least_depth) {
  auto gauss = [&](double a0, double a1, double b0, double b1) {
    static constexpr double kPoints[]{-0.8611363115940526, -0.3399810435848563, 0.3399810435848563, 0.8611363115940526};
    static constexpr double kWeights[]{0.3478548451374538, 0.6521451548625461, 0.6521451548625461, 0.3478548451374538};
    double sum = 0.0;
    for (int i = 0; i < 4; ++i)
      for (int k = 0; k < 4; ++k)
        sum += kWeights[i] * kWeights[k] *
               function(direction(0.5 * (a0 + a1 + kPoints[i] * (a1 - a0)), 0.5 * (b0 + b1 + kPoints[k] * (b1 - b0))));
    return 0.25 * sum * (a1 - a0) * (b1 - b0) * 2.0 * kPi;
  };
  auto refine = [&](auto&& self, double a0, double a1, double b0, double b1, double whole, int depth) -> double {
    double a = 0.5 * (a0 + a1), b = 0.5 * (b0 + b1);
    double parts[4]{gauss(a0, a, b0, b), gauss(a, a1, b0, b), gauss(a0, a, b, b1), gauss(a, a1, b, b1)};
    double sum = parts[0] + parts[1] + parts[2] + parts[3];
    if (depth >= least_depth && (depth == 14 || std::fabs(sum - whole) < 1e-7)) return sum;
    return self(self, a0, a, b0, b, parts[0], depth + 1) + self(self, a, a1, b0, b, parts[1], depth + 1) +
           self(self, a0, a, b, b1, parts[2], depth + 1) + self(self, a, a1, b, b1, parts[3], depth + 1);
  };
  return refine(refine, c0, c1, t0, t1, gauss(c0, c1, t0, t1), 0);
}

// The same on the side of the viewer (1) or behind the surface (-1), between two cosines > 0. Refraction by microfacets
// ends with a cliff where they would stand upright.
template <class Function>
double band_integral(const Function& function, const Specimen& specimen, const Vec3& wo, int side, double low, double high,
                     double t0, double t1, int least_depth) {
  const double cliff = side < 0 ? wo.z / specimen.boundary.eta : 0.0;
  auto part = [&](double a, double b) {
    return std::fabs(patch_integral(function, side * a, side * b, t0, t1, least_depth));
  };
  return cliff > low && cliff < high ? part(low, cliff) + part(cliff, high) : part(low, high);
}

// The same in parts. Light that comes in flat leaves near the horizon in the mirror's azimuth, in a peak the narrower the
// flatter: the parts shrink towards both.
template <class Function>
double graded_integral(const Function& function, const Specimen& specimen, const Vec3& wo, int side, double low, double high,
                       double t0, double t1, int least_depth) {
  static constexpr double kCosines[]{1e-3, 0.01, 0.05, 0.25, 0.5}, kTurnsAway[]{0.0, 1e-4, 1e-3, 0.01, 0.0625, 0.25, 0.5};
  const double mirror = std::atan2(-wo.y, -wo.x) / (2.0 * kPi);
  std::vector<double> cosines{low, high}, turns{t0, t1};
  for (double cosine : kCosines)
    if (cosine > low && cosine < high) cosines.push_back(cosine);
  for (double away : kTurnsAway)
    for (double turn : {mirror + away, mirror - away})
      for (int whole : {-1, 0, 1})
        if (turn + whole > t0 && turn + whole < t1) turns.push_back(turn + whole);
  std::sort(cosines.begin(), cosines.end());
  std::sort(turns.begin(), turns.end());
  double sum = 0.0;
  for (size_t i = 0; i + 1 < cosines.size(); ++i)
    for (size_t k = 0; k + 1 < turns.size(); ++k)
      sum += band_integral(function, specimen, wo, side, cosines[i], cosines[i + 1], turns[k], turns[k + 1], least_depth);
  return sum;
}

constexpr int kBands = 12, kTurns = 16;  // of the histogram; bands on each side

// --- Gate 28

constexpr int kSamples = 1 << 16;

// -log10 of the probability that the samples are from the density.
double density_error(Random& random, uint64_t i) {
  const size_t plain = specimens().size(), number = i % (plain + tilted_specimens().size());
  const Specimen& specimen = number < plain ? specimens()[number] : tilted_specimens()[number - plain];
  const Vec3 wo = random_viewer(random, i / (plain + tilted_specimens().size()));
  const Bsdf bsdf = specimen.bsdf();
  const int sides = specimen.surface.material->refracts ? 2 : 1;
  std::vector<double> counts(sides * kBands * kTurns + 1), expected(counts.size());
  double& elsewhere = counts.back();  // nothing scattered, or into single directions
  uint32_t seed = static_cast<uint32_t>(random());
  for (int k = 0; k < kSamples; ++k) {
    Sampler sampler(static_cast<uint32_t>(k), static_cast<uint32_t>(i), 0, seed);
    BsdfSample sample;
    if (!bsdf.sample(wo, sampler, sample) || sample.specular) {
      ++elsewhere;
      continue;
    }
    int band = std::min(kBands - 1, static_cast<int>(std::fabs(sample.wi.z) * kBands)) + (sample.wi.z < 0.0 ? kBands : 0);
    double turn = std::atan2(sample.wi.y, sample.wi.x) / (2.0 * kPi);
    int column = std::min(kTurns - 1, static_cast<int>((turn < 0.0 ? turn + 1.0 : turn) * kTurns));
    if (band >= sides * kBands) return kInfinity;
    ++counts[band * kTurns + column];
  }
  auto density = [&](const Vec3& wi) {
    double pdf;
    bsdf.evaluate(wo, wi, pdf);
    return pdf;
  };
  double rest = kSamples;
  for (int band = 0; band < sides * kBands; ++band)
    for (int column = 0; column < kTurns; ++column) {
      double low = double(band % kBands) / kBands, high = double(band % kBands + 1) / kBands;
      double& mean = expected[band * kTurns + column];
      mean = kSamples * graded_integral(density, specimen, wo, band < kBands ? 1 : -1, low, high, double(column) / kTurns,
                                        double(column + 1) / kTurns, 1);
      rest -= mean;
    }
  if (rest < -1e-3 * kSamples) return kInfinity;
  expected.back() = std::max(rest, 0.0);
  return -std::log10(std::max(1e-300, p_value(counts, expected)));
}

// --- Gate 29

// Radiance is counted as it would be in vacuum: it is greater by the square of the index of refraction inside.
double weight(const Specimen& specimen, const Vec3& wi, const Rgb& f) {
  return f.x * (wi.z < 0.0 ? specimen.boundary.eta * specimen.boundary.eta : 1.0);
}

double lost_by_samples(Random& random, uint64_t i) {
  const Specimen& specimen = specimens()[i % specimens().size()];
  const Vec3 wo = random_viewer(random, i / specimens().size());
  if (!specimen.white) return 0.0;
  double sum = 0.0, squares = 0.0;
  uint32_t seed = static_cast<uint32_t>(random());
  for (int k = 0; k < kSamples; ++k) {
    Sampler sampler(static_cast<uint32_t>(k), static_cast<uint32_t>(i), 0, seed);
    BsdfSample sample;
    double value = specimen.bsdf().sample(wo, sampler, sample) ? weight(specimen, sample.wi, sample.weight) : 0.0;
    sum += value, squares += value * value;
  }
  double mean = sum / kSamples, error = std::sqrt(std::max(0.0, squares / kSamples - mean * mean) / kSamples);
  return std::fabs(mean - 1.0) / (1e-4 + 5.6 * error);  // 5.6: once in 5e7 cases by chance
}

double lost_in_all(Random& random, uint64_t i) {
  const Specimen& specimen = specimens()[i % specimens().size()];
  const Vec3 wo = random_viewer(random, i / specimens().size());
  const Bsdf bsdf = specimen.bsdf();
  auto f = [&](const Vec3& wi) {
    double pdf;
    return weight(specimen, wi, bsdf.evaluate(wo, wi, pdf));
  };
  double sum = 0.0;
  for (int side : {1, -1}) sum += graded_integral(f, specimen, wo, side, 0.0, 1.0, 0.0, 1.0, 2);
  Beam beams[kMostBeams];
  for (int k = 0, count = bsdf.beams(wo, beams); k < count; ++k) sum += weight(specimen, beams[k].wi, beams[k].weight);
  return specimen.white ? std::fabs(sum - 1.0) : std::max(0.0, sum - 1.0);
}

// --- Reciprocity

double between_ways(Random& random, uint64_t i) {
  const Specimen& there = specimens()[i % specimens().size()];
  const Vec3 a = random_viewer(random, i / specimens().size());
  Vec3 b = direction(1.0 - random() * 0x1p-64, random() * 0x1p-64);
  Specimen back = there;
  double scale = 1.0;
  Vec3 from = b, to = a;
  if (there.surface.material->refracts && random() & 1) {  // through the surface: looked at from behind
    scale = there.boundary.eta * there.boundary.eta;
    back.boundary.eta = there.boundary.entering ? 1.0 / there.surface.material->ior : there.surface.material->ior;
    back.boundary.entering = !there.boundary.entering;
    b.z = -b.z;
    to.z = -a.z;
  }
  double pdf;
  Rgb forth = there.bsdf().evaluate(a, b, pdf) * (scale / std::fabs(b.z));
  Rgb reverse = back.bsdf().evaluate(from, to, pdf) / std::fabs(to.z);
  double largest = std::max(max_component(forth), max_component(reverse));
  if (!(largest > 0.0)) return 0.0;
  // Near the critical angle the last bits of one side's cosine are worth that much of the other's.
  double rounding = 0.0;
  if (b.z < 0.0) {
    const Vec3 facet = glm::normalize(a + there.boundary.eta * b);
    const double cosine = std::min(std::fabs(glm::dot(a, facet)), std::fabs(glm::dot(b, facet)));
    rounding = 8.0 * kUnitRoundoff / (cosine * cosine);
  }
  return std::max(0.0, max_abs(forth - reverse) / largest - rounding);
}

}  // namespace

void add_scattering(std::vector<Case>& out) {
  const uint64_t kinds = 26, tilted = 10;
  out.push_back({"sampling-density", 28, "-log10 of the p-value, 65,536 samples each", 8, Combine::Max, 2 * (kinds + tilted), 10'000,
                 worst_of(density_error), 1});
  out.push_back({"white-samples", 29, "mean off 1, in 1e-4 and 5.6 standard errors", 1, Combine::Max, 2 * kinds, 10'000,
                 worst_of(lost_by_samples), 1});
  out.push_back({"white-albedo", 29, "light lost or made", 1e-4, Combine::Max, 3 * kinds, 100'000, worst_of(lost_in_all), 1});
  out.push_back({"two-ways", 26, "difference, relative", 1e-9, Combine::Max, 100'000, 100'000'000, worst_of(between_ways)});
}

}  // namespace tilecast::stress
