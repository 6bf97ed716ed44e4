// Eight samplers (base/sampler.h) at once, for the first numbers of each: to the same bits.
#pragma once

#include "base/lanes64.h"
#include "base/sampler.h"

namespace tilecast {

using Uint8Lanes = uint32_t __attribute__((vector_size(32)));

class SamplerLanes {
 public:
  SamplerLanes(Uint8Lanes x, Uint8Lanes y, Uint8Lanes sample, uint32_t seed, Sampling sampling) {
    const bool sobol = sampling == Sampling::Sobol;
    index_ = sobol ? reverse(sample >> 1) : Uint8Lanes{};
    key_ = combine(combine(combine(Uint8Lanes{} + hash_mix(seed), x), y), sobol ? sample & 1 : sample);
  }

  // Uniform in [0, 1)^2.
  void next2(Double8& u, Double8& v) {
    const Uint8Lanes key = combine(key_, Uint8Lanes{} + dimension_++);
    const Uint8Lanes i = reverse(permute(index_, key));
    u = to_unit(reverse(permute(i, mix(key + 1))));
    v = to_unit(reverse(permute(second_dimension(i), mix(key + 2))));
  }
  // As it stands, for what follows.
  Sampler lane(int i) const { return Sampler(Sampler::State{index_[i], key_[i], dimension_}); }

 private:
  static Uint8Lanes mix(Uint8Lanes x) {
    x ^= x >> 16;
    x *= 0x21f0aaadu;
    x ^= x >> 15;
    x *= 0x735a2d97u;
    x ^= x >> 15;
    return x;
  }
  static Uint8Lanes combine(Uint8Lanes a, Uint8Lanes b) { return mix(a ^ mix(b + 0x9e3779b9u)); }
  static Uint8Lanes reverse(Uint8Lanes x) {
    x = (x << 16) | (x >> 16);
    x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    return ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
  }
  static Uint8Lanes permute(Uint8Lanes x, Uint8Lanes seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
  }
  static Uint8Lanes second_dimension(Uint8Lanes x) {
    x ^= (x & 0xaaaaaaaau) >> 1;
    x ^= (x & 0xccccccccu) >> 2;
    x ^= (x & 0xf0f0f0f0u) >> 4;
    x ^= (x & 0xff00ff00u) >> 8;
    x ^= (x & 0xffff0000u) >> 16;
    return x;
  }
  static Double8 to_unit(Uint8Lanes x) {
    Double8 out;
    for (int i = 0; i < kLanes; ++i) out.set(i, x[i] * 0x1p-32);
    return out;
  }

  Uint8Lanes index_, key_;
  uint32_t dimension_ = 0;
};

}  // namespace tilecast
