// What materials need beside their parameters: a blend what its parts have in common, rough ones their energy tables.
#include <map>

#include "base/check.h"
#include "optics/energy_between.h"
#include "scene/builder.h"

namespace tilecast {
namespace {
constexpr size_t kMostPairs = 64, kMostTables = 256;  // a pair takes half a second, other tables a fifth of that
}

void SceneBuilder::blend(Material& m) const {
  double sum = 0.0;
  for (int i = 0; i < Material::kMostParts; ++i) {
    if (!(m.shares[i] >= 0.0 && m.shares[i] <= 1.0))
      throw Error("weight: must lie between 0 and 1, got " + text(m.shares[i]));
    if (m.shares[i] == 0.0) continue;
    sum += m.shares[i];
    if (m.parts[i] < 0 || m.parts[i] >= static_cast<int>(scene_.materials.size())) throw Error("of: no such material");
    const Material& part = scene_.materials[m.parts[i]];
    std::string where = "of[" + std::to_string(i) + "]: ";
    if (part.kind == MaterialKind::Blend) throw Error(where + "a blend takes materials that are no blends themselves");
    if (part.normal_map >= 0) throw Error(where + "a normal map belongs to the blend, not to the materials that it takes");
    m.textured |= part.textured;
    m.uses_uv |= part.uses_uv;
    if (part.emits() || part.opacity < 1.0)
      throw Error(where + "emission and opacity belong to the blend, not to the materials that it takes");
    if (!part.refracts) continue;
    if (m.refracts) throw Error(where + "a blend takes one dielectric at most: its inside can be of one kind alone");
    m.refracts = true;
    m.ior = part.ior;
    m.dispersion = part.dispersion;
    m.absorption = part.absorption;
    m.priority = part.priority;
  }
  if (!(std::fabs(sum - 1.0) <= 1e-9)) throw Error("weight: the parts of a blend must be 1 together, got " + text(sum));
}

void SceneBuilder::finish_materials() {
  std::map<double, int> media{{1.0, 0}};  // by index of refraction
  for (Material& m : scene_.materials)
    if (m.refracts) m.medium = media.emplace(m.ior, static_cast<int>(media.size())).first->second;
  std::vector<double> iors(media.size());
  for (const auto& [ior, number] : media) iors[number] = ior;

  struct Keys {  // what tables are for: roughness and index of refraction, each once
    std::map<std::pair<double, double>, int> numbers;
    std::vector<std::pair<double, double>> list;
    int number(double roughness, double eta) {
      auto [found, added] = numbers.emplace(std::pair(roughness, eta), static_cast<int>(list.size()));
      if (added) list.push_back(found->first);
      return found->second;
    }
  } conductors, coats, dielectrics;
  for (Material& m : scene_.materials) {
    const double roughness = m.smooth() ? 0.0 : m.roughness;
    const bool tables = m.kind == MaterialKind::Plastic || m.kind == MaterialKind::Conductor;
    if (tables && m.roughness_texture >= 0) {
      m.energy = static_cast<int>(scene_.roughness_levels.size());
      const int last = static_cast<int>(std::ceil(roughness * kRoughnessLevels));
      for (int level = m.first_level; level <= last; ++level) {
        const double of_level = static_cast<double>(level) / kRoughnessLevels;
        scene_.roughness_levels.push_back(m.kind == MaterialKind::Plastic
                                              ? coats.number(of_level, m.ior)
                                              : conductors.number(std::max(of_level, kLeastRoughness), 0.0));
      }
    } else if (m.kind == MaterialKind::Plastic) {
      m.energy = coats.number(roughness, m.ior);
    } else if (m.kind == MaterialKind::Conductor && roughness > 0.0) {
      m.energy = conductors.number(roughness, 0.0);
    } else if (m.kind == MaterialKind::Dielectric && roughness > 0.0) {
      m.energy = static_cast<int>(scene_.pairs.size());
      for (double beside : iors) {
        const double eta = m.ior / beside;
        const bool smooth = std::fabs(eta - 1.0) < kLeastContrast;
        scene_.pairs.push_back(smooth ? -1 : dielectrics.number(roughness, eta));
        if (dielectrics.list.size() > kMostPairs)
          throw Error("more than " + std::to_string(kMostPairs) + " pairs of a rough dielectric and an index of " +
                      "refraction beside it: give more of them the same roughness and ior");
      }
    }
  }
  if (std::max(conductors.list.size(), coats.list.size()) > kMostTables)
    throw Error("more than " + std::to_string(kMostTables) + " different roughnesses of metals, or of plastics: give " +
                "more of them the same roughness (and ior)");
  for (auto [rough, none] : conductors.list) scene_.conductor_losses.push_back(EnergyTable::conductor_loss(rough));
  for (auto [rough, eta] : coats.list) scene_.coat_energies.push_back(coat_energy(rough, eta));
  for (auto [rough, eta] : dielectrics.list) scene_.dielectric_energies.push_back(dielectric_energy(rough, eta));
}

}  // namespace tilecast
