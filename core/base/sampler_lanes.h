// The points of several samples at once: those of base/sampler.h, bit for bit.
#pragma once

#include "base/lanes64.h"
#include "base/sampler.h"

namespace tilecast {

using Uint8Lanes = uint32_t __attribute__((vector_size(32)));

namespace lanes {

template <class Uint>
Uint reverse(Uint x) {
  x = (x << 16) | (x >> 16);
  x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
  x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
  x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
  return ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
}
#ifdef __AVX2__
inline Uint4 reverse(Uint4 x) {
  const __m128i bytes = _mm_setr_epi8(3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12);
  const __m128i low = _mm_setr_epi8(0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15);  // a half byte, reversed
  const __m128i four = _mm_set1_epi8(15), turned = _mm_shuffle_epi8((__m128i)x, bytes);
  const __m128i high = _mm_shuffle_epi8(low, _mm_and_si128(turned, four));
  const __m128i rest = _mm_shuffle_epi8(low, _mm_and_si128(_mm_srli_epi16(turned, 4), four));
  return (Uint4)_mm_or_si128(_mm_slli_epi16(high, 4), rest);
}
#endif

inline Double8 to_double(Uint8Lanes x) {
  return {tilecast::to_double(__builtin_shufflevector(x, x, 0, 1, 2, 3)),
          tilecast::to_double(__builtin_shufflevector(x, x, 4, 5, 6, 7))};
}
inline Double4 to_unit(Uint4 x) { return tilecast::to_double(x) * 0x1p-32; }
inline Double8 to_unit(Uint8Lanes x) { return to_double(x) * 0x1p-32; }

}  // namespace lanes

// Uint: Uint4, whose points are Double4, or Uint8Lanes and Double8.
template <class Uint>
class SamplerLanes {
 public:
  using Double = decltype(lanes::to_unit(Uint{}));

  // Of each: Sampler::index() and key().
  SamplerLanes(Uint index, Uint key) : index_(index), key_(key) {}
  SamplerLanes(Uint x, Uint y, Uint sample, uint32_t seed, Sampling sampling) {
    const bool sobol = sampling == Sampling::Sobol;
    index_ = sobol ? lanes::reverse(sample >> 1) : Uint{};
    key_ = hash_combine(hash_combine(hash_combine(Uint{} + hash_mix(seed), x), y), sobol ? sample & 1 : sample);
  }

  Uint index() const { return index_; }
  Uint key() const { return key_; }
  // One of them, after so many calls.
  Sampler lane(int i, uint32_t dimension) const { return {index_[i], key_[i], dimension}; }

  // What Sampler would give next after so many calls: as many in all lanes (uint32_t), or in each as many (Uint).
  template <class Dimension>
  Double next1(Dimension dimension) const {
    const Uint key = key_of(dimension);
    return lanes::to_unit(lanes::reverse(sobol::permute(shuffled(key), hash_mix(key + 1))));
  }
  template <class Dimension>
  void next2(Dimension dimension, Double& x, Double& y) const {
    const Uint key = key_of(dimension), i = shuffled(key);
    x = lanes::to_unit(lanes::reverse(sobol::permute(i, hash_mix(key + 1))));
    y = lanes::to_unit(lanes::reverse(sobol::permute(sobol::second_dimension(i), hash_mix(key + 2))));
  }

 private:
  template <class Dimension>
  Uint key_of(Dimension dimension) const { return hash_mix(key_ ^ hash_mix(dimension + 0x9e3779b9u)); }  // hash_combine
  Uint shuffled(Uint key) const { return lanes::reverse(sobol::permute(index_, key)); }

  Uint index_, key_;
};

}  // namespace tilecast
