// Boundaries between dielectrics: what they reflect, held against quadruple precision, and what lies on their sides
// where several overlap, held against the arrangement that the scene was made from.
#include "optics/fresnel.h"
#include "shading/medium.h"
#include "stress/quad.h"
#include "stress/scenes.h"
#include "stress/stress.h"

namespace tilecast::stress {
namespace {

struct QuadFresnel {
  Quad reflectance = 1, transmittance = 0, cos_transmitted = 0;
  bool total = true;
};

// The two polarisations' amplitudes, by Fresnel's own formulas.
QuadFresnel fresnel_in_quad(Quad c, Quad eta) {
  Quad c2 = c * c, eta2 = eta * eta;  // exact; so is the difference of one of them from 1 where the sum nearly cancels
  Quad g2 = c2 >= 0.5 ? eta2 + (c2 - 1) : (eta2 - 1) + c2;
  if (g2 <= 0) return {};
  Quad g = root_of(g2), p = eta * eta * c;
  Quad s = c + g, t = p + g;
  Quad transmittance = 2 * c * g * (1 / (s * s) + eta * eta / (t * t));
  return {(square((c - g) / s) + square((p - g) / t)) / 2, transmittance, g / eta, false};
}

struct Incidence {
  double cosine, eta;
};

// Ratios of indices from 1e-3 to 1e3, many within 1e-12 of 1; angles of all kinds, many grazing or near the critical.
Incidence random_incidence(Random& random) {
  std::uniform_real_distribution<double> unit(0, 1), exponent(-3, 3), small(-12, 0);
  Incidence out;
  switch (random() % 4) {
    case 0: out.eta = std::pow(10.0, exponent(random)); break;
    case 1: out.eta = 1.0 + 0.5 * std::pow(10.0, small(random)) * (random() & 1 ? 1 : -1); break;
    case 2: out.eta = 1.0 + (random() & 1 ? 1e-12 : -1e-12); break;
    default: out.eta = random() & 1 ? 1.5 : 1.0 / 1.5; break;
  }
  double critical = out.eta < 1.0 ? std::sqrt((1.0 - out.eta) * (1.0 + out.eta)) : 0.5;
  switch (random() % 4) {
    case 0: out.cosine = unit(random); break;
    case 1: out.cosine = std::pow(10.0, small(random)); break;
    case 2:
      out.cosine = std::min(1.0, critical * (1.0 + std::pow(10.0, small(random)) * (random() & 1 ? 1 : -1)));
      break;
    default: out.cosine = std::min(1.0, critical + static_cast<double>(random() % 9) * 0x1p-54); break;
  }
  out.cosine = std::max(out.cosine, 1e-30);
  return out;
}

double relative(Quad got, Quad exact) {
  return exact == 0 ? (got == 0 ? 0.0 : kInfinity) : static_cast<double>(magnitude(got - exact) / magnitude(exact));
}

double fresnel_error(Random& random, uint64_t) {
  auto [cosine, eta] = random_incidence(random);
  Fresnel got = fresnel_dielectric(cosine, eta);
  QuadFresnel exact = fresnel_in_quad(cosine, eta);
  return std::max(relative(got.reflectance, exact.reflectance), relative(got.cos_transmitted, exact.cos_transmitted)) /
         (16 * kUnitRoundoff);
}

double wrong_decision(Random& random, uint64_t) {
  auto [cosine, eta] = random_incidence(random);
  Fresnel got = fresnel_dielectric(cosine, eta);
  bool total = fresnel_in_quad(cosine, eta).total;
  return got.total != total || got.total != (got.cos_transmitted == 0.0) || (total && got.reflectance != 1.0);
}

double energy_error(Random& random, uint64_t) {
  auto [cosine, eta] = random_incidence(random);
  Quad sum = fresnel_dielectric(cosine, eta).reflectance + fresnel_in_quad(cosine, eta).transmittance;
  return static_cast<double>(magnitude(sum - 1)) / (4 * kUnitRoundoff);
}

// From the other side as much is reflected, but for what the rounding of the two arguments there is worth.
double reciprocity_error(Random& random, uint64_t) {
  auto [cosine, eta] = random_incidence(random);
  Fresnel here = fresnel_dielectric(cosine, eta);
  if (here.total) return 0.0;
  double back = here.cos_transmitted, inverse = 1.0 / eta;
  Quad least = 1, most = 0;
  for (int i = -2; i <= 2; ++i)
    for (int k = -2; k <= 2; ++k) {
      Quad r = fresnel_in_quad(back * (1 + Quad(i) * kUnitRoundoff), inverse * (1 + Quad(k) * kUnitRoundoff)).reflectance;
      least = r < least ? r : least;
      most = larger(most, r);
    }
  Quad there = fresnel_dielectric(std::min(1.0, back), inverse).reflectance;
  Quad away = larger(larger(least - here.reflectance, here.reflectance - most), larger(least - there, there - most));
  return static_cast<double>(larger(away, 0)) / (8 * kUnitRoundoff);
}

// --- Four blocks along x in every order of their eight ends and of their priorities; a ray follows the axis from a
// place between two ends. What counts there is known from the arrangement alone.

constexpr int kMedia = 4;

const std::vector<std::array<int, 2 * kMedia>>& orders_of_ends() {
  static const std::vector<std::array<int, 2 * kMedia>> all = [] {
    std::vector<std::array<int, 2 * kMedia>> out;
    std::array<int, 2 * kMedia> ends{0, 0, 1, 1, 2, 2, 3, 3};
    do out.push_back(ends);
    while (std::next_permutation(ends.begin(), ends.end()));
    return out;
  }();
  return all;
}

double wrong_media(Random& random, uint64_t i) {
  const auto& ends = orders_of_ends()[i % orders_of_ends().size()];
  std::array<int, kMedia> priorities{0, 1, 2, 3};
  for (uint64_t k = i / orders_of_ends().size() % 24; k > 0; --k) std::next_permutation(priorities.begin(), priorities.end());

  SceneBuilder builder;
  std::vector<InstanceSource> placed;
  double first[kMedia], last[kMedia];
  for (int m = 0; m < kMedia; ++m) {
    first[m] = std::find(ends.begin(), ends.end(), m) - ends.begin();
    last[m] = ends.rend() - std::find(ends.rbegin(), ends.rend(), m) - 1;
    double half = 1.0 + 0.1 * m;
    Material material{.kind = MaterialKind::Dielectric, .ior = 1.25 + 0.25 * m, .priority = priorities[m] - 1};
    placed.push_back({builder.add_solid(Block{Vec3(first[m], -half, -half), Vec3(last[m], half, half)}), Affine{},
                      builder.add_material(material)});
  }
  auto scene = scene_of(builder, placed);
  auto counting = [&](double x) {  // which medium counts at x; -1: none
    int best = -1;
    for (int m = 0; m < kMedia; ++m)
      if (first[m] < x && x < last[m] && (best < 0 || priorities[m] > priorities[best])) best = m;
    return best;
  };
  auto index = [](int medium) { return medium < 0 ? 1.0 : 1.25 + 0.25 * medium; };

  int side = random() & 1 ? 1 : -1;
  double x = static_cast<double>(random() % (2 * kMedia + 1)) - 0.5;
  Ray ray{{x, 0.1, 0.2}, {static_cast<double>(side), 0.0, 0.0}};
  Media media = media_at(*scene, ray.origin);
  for (;; x += side) {
    if (media.ior() != index(counting(x))) return 1.0;
    Hit hit = closest(*scene, ray);
    if (!hit.found()) return side > 0 ? x < 2 * kMedia - 1 : x > 0.0;
    if (std::fabs(hit.t - std::fabs(x + 0.5 * side - ray.origin.x)) > 1e-9) return 1.0;
    const Material& material = *resolve(*scene, ray, hit).material;
    Boundary boundary = media.at(material, hit.entering);
    int before = counting(x), after = counting(x + side);
    if (boundary.real != (before != after)) return 1.0;
    if (boundary.real && boundary.eta != index(after) / index(before)) return 1.0;
    media.cross(material, hit.entering);
    ray.t_min = hit.t;
  }
}

}  // namespace

void add_dielectrics(std::vector<Case>& out) {
  out.push_back({"fresnel", 25, "error of reflectance and angle, in 16 u", 1, Combine::Max, 1'000'000, 1'000'000'000,
                 worst_of(fresnel_error)});
  out.push_back({"total-reflection", 26, "wrong decisions", 0, Combine::Sum, 1'000'000, 1'000'000'000,
                 sum_of(wrong_decision)});
  out.push_back({"fresnel-energy", 26, "reflected and transmitted, less 1, in 4 u", 1, Combine::Max, 1'000'000,
                 1'000'000'000, worst_of(energy_error)});
  out.push_back({"fresnel-reciprocity", 26, "difference between the sides, in 8 u", 1, Combine::Max, 20'000,
                 1'000'000'000, worst_of(reciprocity_error)});
  out.push_back({"nested-media", 27, "rays that meet a wrong index", 0, Combine::Sum, 60'480, 2'000'000,
                 sum_of(wrong_media), 256});
}

}  // namespace tilecast::stress
