// An energy table, or what lies between those of two roughnesses next to each other: roughness from a texture would need
// a table for each of its values.
#pragma once

#include "optics/energy.h"

namespace tilecast {

// Tables at 0, 1/16, ... 1. Between them a white surface gives back all light to within 0.003; seen at 4 degrees and
// smoother than 0.1, to within 0.01.
inline constexpr int kRoughnessLevels = 16;

class EnergyBetween {
 public:
  EnergyBetween(const EnergyTable& table) : low_(table), high_(table), share_(0.0) {}
  EnergyBetween(const EnergyTable& low, const EnergyTable& high, double share) : low_(low), high_(high), share_(share) {}

  double at(double cosine) const {
    const double low = low_.at(cosine);
    return share_ == 0.0 ? low : low + share_ * (high_.at(cosine) - low);
  }
  double average() const { return low_.average() + share_ * (high_.average() - low_.average()); }

 private:
  const EnergyTable &low_, &high_;
  double share_;
};

}  // namespace tilecast
