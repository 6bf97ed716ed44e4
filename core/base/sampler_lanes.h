// The points of four samples at once: those of base/sampler.h, bit for bit.
#pragma once

#include "base/double_lanes.h"
#include "base/sampler.h"

namespace tilecast {

class SamplerLanes {
 public:
  // Of each: Sampler::index() and key().
  SamplerLanes(Uint4 index, Uint4 key) : index_(index), key_(key) {}

  Uint4 index() const { return index_; }
  Uint4 key() const { return key_; }

  // What Sampler would give next after so many calls.
  Double4 next1(uint32_t dimension) const {
    const Uint4 key = key_of(dimension);
    return to_unit(reverse(permute(shuffled(key), hash_mix(key + 1))));
  }
  void next2(uint32_t dimension, Double4& x, Double4& y) const {
    const Uint4 key = key_of(dimension), i = shuffled(key);
    x = to_unit(reverse(permute(i, hash_mix(key + 1))));
    y = to_unit(reverse(permute(second_dimension(i), hash_mix(key + 2))));
  }

 private:
  static Uint4 hash_mix(Uint4 x) {
    x ^= x >> 16;
    x *= 0x21f0aaadu;
    x ^= x >> 15;
    x *= 0x735a2d97u;
    x ^= x >> 15;
    return x;
  }
  static Uint4 reverse(Uint4 x) {
#ifdef __AVX2__
    const __m128i bytes = _mm_setr_epi8(3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12);
    const __m128i low = _mm_setr_epi8(0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15);  // a half byte, reversed
    const __m128i four = _mm_set1_epi8(15), turned = _mm_shuffle_epi8((__m128i)x, bytes);
    const __m128i high = _mm_shuffle_epi8(low, _mm_and_si128(turned, four));
    const __m128i rest = _mm_shuffle_epi8(low, _mm_and_si128(_mm_srli_epi16(turned, 4), four));
    return (Uint4)_mm_or_si128(_mm_slli_epi16(high, 4), rest);
#else
    x = ((x >> 16)) | (x << 16);
    x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    return ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
#endif
  }
  static Uint4 permute(Uint4 x, Uint4 seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
  }
  static Uint4 second_dimension(Uint4 x) {
    x ^= (x & 0xaaaaaaaau) >> 1;
    x ^= (x & 0xccccccccu) >> 2;
    x ^= (x & 0xf0f0f0f0u) >> 4;
    x ^= (x & 0xff00ff00u) >> 8;
    x ^= (x & 0xffff0000u) >> 16;
    return x;
  }
  static Double4 to_unit(Uint4 x) { return to_double(x) * 0x1p-32; }
  Uint4 key_of(uint32_t dimension) const { return hash_mix(key_ ^ tilecast::hash_mix(dimension + 0x9e3779b9u)); }
  Uint4 shuffled(Uint4 key) const { return reverse(permute(index_, key)); }

  Uint4 index_, key_;
};

}  // namespace tilecast
