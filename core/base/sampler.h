// Owen-scrambled Sobol points in padded pairs of dimensions, keyed by (pixel, sample index, seed) and nothing else. Or,
// for comparison, independent ones: of each sample's own sequence the first point.
//
// Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020; the permutation's constants are Vegdahl's. Even and
// odd sample indices are two independently scrambled sequences: two independent estimates of the pixel, which is what
// the error estimate stands on.
#pragma once

#include "base/vec.h"

namespace tilecast {

// Wellons, lowbias32. Of uint32_t, or of a vector of them.
template <class Uint>
inline Uint hash_mix(Uint x) {
  x ^= x >> 16;
  x *= 0x21f0aaadu;
  x ^= x >> 15;
  x *= 0x735a2d97u;
  x ^= x >> 15;
  return x;
}
template <class Uint>
inline Uint hash_combine(Uint a, Uint b) {
  return hash_mix(a ^ hash_mix(b + 0x9e3779b9u));
}

namespace sobol {

// Permutes so that each bit depends on lower bits alone: an Owen scramble of the reversed number.
template <class Uint>
inline Uint permute(Uint x, Uint seed) {
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return x;
}
// The second dimension, reversed: the Pascal matrix modulo 2, a product of five shears.
template <class Uint>
inline Uint second_dimension(Uint x) {
  x ^= (x & 0xaaaaaaaau) >> 1;
  x ^= (x & 0xccccccccu) >> 2;
  x ^= (x & 0xf0f0f0f0u) >> 4;
  x ^= (x & 0xff00ff00u) >> 8;
  x ^= (x & 0xffff0000u) >> 16;
  return x;
}

}  // namespace sobol

enum class Sampling : uint8_t { Sobol, Independent };
inline constexpr const char* kSamplingNames[]{"sobol", "independent"};

class Sampler {
 public:
  Sampler(uint32_t x, uint32_t y, uint32_t sample, uint32_t seed, Sampling sampling = Sampling::Sobol)
      : Sampler(key_of_pixel(x, y, seed), sample, sampling) {}
  // The same, from what the samples of a pixel have in common.
  Sampler(uint32_t pixel_key, uint32_t sample, Sampling sampling)
      : index_(sampling == Sampling::Sobol ? reverse(sample >> 1) : 0),
        key_(hash_combine(pixel_key, sampling == Sampling::Sobol ? sample & 1 : sample)) {}
  static uint32_t key_of_pixel(uint32_t x, uint32_t y, uint32_t seed) {
    return hash_combine(hash_combine(hash_mix(seed), x), y);
  }

  // Uniform in [0, 1).
  double next1() {
    uint32_t key = next_key();
    return to_unit(reverse(sobol::permute(shuffled(key), hash_mix(key + 1))));
  }
  // Uniform in [0, 1)^2; Sobol points are well spread over the samples of a pixel.
  Vec2 next2() {
    uint32_t key = next_key();
    uint32_t i = shuffled(key);
    return {to_unit(reverse(sobol::permute(i, hash_mix(key + 1)))),
            to_unit(reverse(sobol::permute(sobol::second_dimension(i), hash_mix(key + 2))))};
  }

  // As it stands after so many calls; of what index() and key() tell.
  Sampler(uint32_t index, uint32_t key, uint32_t dimension) : index_(index), key_(key), dimension_(dimension) {}

  // What sets this sample's numbers apart from those of others, and how many calls have been answered: for those who take
  // the numbers of several samples at once (base/sampler_lanes.h).
  uint32_t index() const { return index_; }
  uint32_t key() const { return key_; }
  uint32_t dimension() const { return dimension_; }

 private:
  static uint32_t reverse(uint32_t x) {
    x = __builtin_bswap32(x);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    return ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
  }
  static double to_unit(uint32_t x) { return x * 0x1p-32; }
  uint32_t next_key() { return hash_combine(key_, dimension_++); }
  // The order of the points is shuffled apart for each pair of dimensions.
  uint32_t shuffled(uint32_t key) const { return reverse(sobol::permute(index_, key)); }

  uint32_t index_, key_, dimension_ = 0;
};

}  // namespace tilecast
