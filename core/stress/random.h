// Random numbers for cases: a generator that costs nothing to start anew for each.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

namespace tilecast::stress {

// SplitMix64 (Steele, Lea, Flood 2014: "Fast splittable pseudorandom number generators").
class Random {
 public:
  using result_type = uint64_t;

  explicit Random(uint64_t seed) : state_(mix(seed)) {}
  static constexpr uint64_t min() { return 0; }
  static constexpr uint64_t max() { return ~uint64_t(0); }
  uint64_t operator()() { return mix(state_ += 0x9e3779b97f4a7c15); }

 private:
  static constexpr uint64_t mix(uint64_t x) {
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9;
    x = (x ^ x >> 27) * 0x94d049bb133111eb;
    return x ^ x >> 31;
  }
  uint64_t state_;
};

inline double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}
inline double power_of_ten(Random& random, double low, double high) {
  return std::pow(10.0, uniform(random, low, high));
}

}  // namespace tilecast::stress
