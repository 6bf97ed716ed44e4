#include "optics/energy.h"

#include <map>
#include <mutex>

#include "optics/fresnel.h"
#include "optics/microfacet.h"

namespace tilecast {
namespace {

constexpr double kTolerance = 5e-6;     // of an integral
constexpr double kMostBend = 1e-4;      // of a panel, off a straight line
constexpr int kFirstKnots = 16, kMostHalvings = 14;

constexpr double kHeights[]{0.0, 0.02, 0.5, 0.95, 0.998, 0.9999, 1.0};  // the steepest microfacets come last

// Gauss and Legendre's rule of 8 points on [-1, 1].
constexpr double kPoints[8]{-0.9602898564975363, -0.7966664774136267, -0.5255324099163290, -0.1834346424956498,
                            0.1834346424956498,  0.5255324099163290,  0.7966664774136267,  0.9602898564975363};
constexpr double kWeights[8]{0.1012285362903763, 0.2223810344533745, 0.3137066458778873, 0.3626837833783620,
                             0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};

// The integral over [a, b], halved where that makes a difference: steps, as at the horizon, are met so.
template <class Function>
double integral(const Function& function, double a, double b) {
  auto gauss = [&](double from, double to) {
    double sum = 0.0, half = 0.5 * (to - from), middle = 0.5 * (to + from);
    for (int i = 0; i < 8; ++i) sum += kWeights[i] * function(middle + half * kPoints[i]);
    return half * sum;
  };
  auto refine = [&](auto&& self, double from, double to, double whole, int halvings) -> double {
    double middle = 0.5 * (from + to), left = gauss(from, middle), right = gauss(middle, to);
    if (halvings == kMostHalvings || std::fabs(left + right - whole) < kTolerance) return left + right;
    return self(self, from, middle, left, halvings + 1) + self(self, middle, to, right, halvings + 1);
  };
  return refine(refine, a, b, gauss(a, b), 0);
}

// The mean of share(wo, m, cosine of the angle between them) over the microfacets m seen from wo.
template <class Share>
double mean_over_seen(double roughness, double cosine, const Share& share) {
  const Ggx ggx(roughness);
  const Vec3 wo(std::sqrt((1.0 - cosine) * (1.0 + cosine)), 0.0, cosine);
  auto ring = [&](double turn) {
    auto at = [&](double height) {
      Vec3 m = ggx.sample_normal(wo, {turn, height});
      return share(ggx, wo, m, glm::dot(wo, m));
    };
    double sum = 0.0;
    for (size_t i = 1; i < std::size(kHeights); ++i) sum += integral(at, kHeights[i - 1], kHeights[i]);
    return sum;
  };
  // Half a turn: the other half is its mirror image.
  return 2.0 * (integral(ring, 0.0, 0.05) + integral(ring, 0.05, 0.45) + integral(ring, 0.45, 0.5));
}

// A table takes a tenth of a second, and every load of a scene asks for the same ones: they are kept, within bounds.
template <class Table, class Make>
Table kept(double roughness, double eta, const Make& make) {
  static std::mutex mutex;
  static std::map<std::pair<double, double>, Table> tables;
  {
    std::lock_guard lock(mutex);
    if (auto found = tables.find({roughness, eta}); found != tables.end()) return found->second;
  }
  Table table = make();
  std::lock_guard lock(mutex);
  if (tables.size() >= 512) tables.clear();
  tables.emplace(std::pair(roughness, eta), table);
  return table;
}

double reflected(const Ggx& ggx, const Vec3& wo, const Vec3& m, double c) {
  Vec3 wi = 2.0 * c * m - wo;
  return wi.z > 0.0 ? ggx.visible_of_seen(wo, wi) : 0.0;
}

double transmitted(const Ggx& ggx, const Vec3& wo, const Vec3& m, double c, double eta, double cos_transmitted) {
  Vec3 wi = (c / eta - cos_transmitted) * m - wo / eta;
  return wi.z < 0.0 ? ggx.visible_of_seen(wo, wi) : 0.0;
}

}  // namespace

// layer: the cosine below which the function changes quickly; kink: a cosine about which it does, to within `layer`.
template <class Function>
EnergyTable::EnergyTable(const Function& function, double layer, double kink) {
  struct Knot {
    double cosine, value;
  };
  auto knot = [&](double cosine) { return Knot{cosine, std::clamp(function(cosine), 0.0, 1.0)}; };
  std::vector<double> first;
  for (int i = 0; i <= kFirstKnots; ++i) {  // evenly in c (1 + layer) / (c + layer)
    double s = double(i) / kFirstKnots;
    first.push_back(i == 0 ? 1e-6 * layer : i == kFirstKnots ? 1.0 : layer * s / (1.0 + layer - s));
  }
  for (double away : {-8.0, -2.0, -0.5, 0.0, 0.5, 2.0, 8.0})
    if (double c = kink + away * layer; kink > 0.0 && c > first[0] && c < 1.0) first.push_back(c);
  std::sort(first.begin(), first.end());

  auto refine = [&](auto&& self, const Knot& a, const Knot& b, int halvings) -> void {
    Knot middle = knot(0.5 * (a.cosine + b.cosine));
    double bend = middle.value - 0.5 * (a.value + b.value);
    if (halvings < 7 && std::fabs(bend) > kMostBend) {
      self(self, a, middle, halvings + 1);
      self(self, middle, b, halvings + 1);
    } else {
      starts_.push_back(a.cosine);
      panels_.push_back({1.0 / (b.cosine - a.cosine), a.value, b.value - a.value, 4.0 * bend});
      average_ += (b.cosine - a.cosine) / 3.0 *  // Simpson's rule, exact here
                  (a.cosine * a.value + 4.0 * middle.cosine * middle.value + b.cosine * b.value);
    }
  };
  Knot last = knot(first[0]);
  for (size_t i = 1; i < first.size(); ++i) {
    Knot next = knot(first[i]);
    refine(refine, last, next, 0);
    last = next;
  }
  guide_ = Guide(std::span(starts_).subspan(1), 4 * starts_.size());
}

double EnergyTable::at(double cosine) const {
  const size_t panel = guide_.above(&starts_[1], cosine);
  const Panel& p = panels_[panel];
  double t = std::clamp((cosine - starts_[panel]) * p.inverse_width, 0.0, 1.0);
  return std::max(0.0, p.value + t * (p.rise + (1.0 - t) * p.bend));
}

EnergyTable EnergyTable::conductor_loss(double roughness) {
  auto loss = [&](double c) { return 1.0 - mean_over_seen(roughness, c, reflected); };
  return kept<EnergyTable>(roughness, 0.0, [&] { return EnergyTable(loss, roughness * roughness, 0.0); });
}

EnergyTable EnergyTable::dielectric_loss(double roughness, double eta) {
  auto both = [&](const Ggx& ggx, const Vec3& wo, const Vec3& m, double c) {
    Fresnel fresnel = fresnel_dielectric(std::clamp(c, 0.0, 1.0), eta);
    double sum = fresnel.reflectance * reflected(ggx, wo, m, c);
    if (!fresnel.total) sum += (1.0 - fresnel.reflectance) * transmitted(ggx, wo, m, c, eta, fresnel.cos_transmitted);
    return sum;
  };
  double critical = eta < 1.0 ? std::sqrt((1.0 - eta) * (1.0 + eta)) : 0.0;
  auto loss = [&](double c) { return 1.0 - mean_over_seen(roughness, c, both); };
  return EnergyTable(loss, roughness * roughness, critical);
}

EnergyTable EnergyTable::coat_reflection(double roughness, double eta) {
  if (roughness == 0.0)
    return EnergyTable([&](double c) { return fresnel_dielectric(c, eta).reflectance; }, 0.1, 0.0);
  auto once = [&](const Ggx& ggx, const Vec3& wo, const Vec3& m, double c) {
    return fresnel_dielectric(std::clamp(c, 0.0, 1.0), eta).reflectance * reflected(ggx, wo, m, c);
  };
  return EnergyTable([&](double c) { return mean_over_seen(roughness, c, once); }, roughness * roughness, 0.0);
}

double average_reflectance(double eta, double k) {
  return integral([&](double c) { return 2.0 * c * fresnel_conductor(c, eta, k); }, 0.0, 1.0);
}

// Reciprocal where (1 / eta^2) of what goes from front to back equals what goes from back to front. The shares of
// smooth surfaces in uniform light do, but for the ratio of the two losses.
DielectricEnergy dielectric_energy(double roughness, double eta) {
  if (eta < 1.0) {
    DielectricEnergy turned = dielectric_energy(roughness, 1.0 / eta);
    return {turned.back, turned.front};
  }
  return kept<DielectricEnergy>(roughness, eta, [&]() -> DielectricEnergy {
    EnergyTable front = EnergyTable::dielectric_loss(roughness, eta);
    EnergyTable back = EnergyTable::dielectric_loss(roughness, 1.0 / eta);
    double through = 1.0 - EnergyTable::coat_reflection(0.0, eta).average(), f = front.average(), b = back.average();
    return {{front, f > 0.0 ? through * std::min(1.0, b / f) : 0.0},
            {back, b > 0.0 ? through / (eta * eta) * std::min(1.0, f / b) : 0.0}};
  });
}

CoatEnergy coat_energy(double roughness, double eta) {
  return kept<CoatEnergy>(roughness, eta, [&]() -> CoatEnergy {
    double through = 1.0 - EnergyTable::coat_reflection(0.0, eta).average();
    return {EnergyTable::coat_reflection(roughness, eta), 1.0 - through / (eta * eta)};
  });
}

}  // namespace tilecast
