// Gate 31: sums do not stall. A pixel's samples are added up as rendering does it, 1,024 at a time and even and odd ones apart
// (render/chunk.cpp), then chunk by chunk (render/sums.h); against the same terms in twice the precision.
#include <array>

#include "render/sums.h"
#include "stress/stress.h"

namespace tilecast::stress {
namespace {

constexpr uint64_t kChunk = 1024;
constexpr int kKinds = 6;

// Constants, whose rounding errors all go one way for a long time; random terms; and those of which a few are nearly all.
double term(int kind, Random& random) {
  switch (kind) {
    case 0: return 0.3;
    case 1: return 0.9999;
    case 2: return 1.0 / 3.0;
    case 3: return uniform(random, 0, 1);
    case 4: return random() % 1'000'000 ? 1e-9 : 1e9;
    default: return power_of_ten(random, -8, 8);
  }
}

// The largest relative error of a sum, in 1e-12.
double sum_error(uint64_t, uint64_t count) {
  Random random(31);
  std::array<double, 2 * kKinds> total{}, lost{};
  std::array<Twofold, kKinds> exact{};
  for (uint64_t first = 0; first < count; first += kChunk) {
    std::array<double, 2 * kKinds> chunk{};
    for (uint64_t i = first; i < std::min(count, first + kChunk); ++i)
      for (int kind = 0; kind < kKinds; ++kind) {
        const double value = term(kind, random);
        chunk[2 * kind + (i & 1)] += value;
        exact[kind] = exact[kind] + Twofold(value);
      }
    add_sums(total.data(), lost.data(), chunk.data(), total.size());
  }
  double worst = 0.0;
  for (int kind = 0; kind < kKinds; ++kind) {
    const Twofold off = Twofold(total[2 * kind]) + Twofold(total[2 * kind + 1]) - exact[kind];
    worst = std::max(worst, std::fabs(off.value() / exact[kind].value()));
  }
  return worst / 1e-12;
}

}  // namespace

void add_long_sums(std::vector<Case>& out) {
  out.push_back({"long-sums", 31, "error of a pixel's sum, relative, in 1e-12", 1, Combine::Max, 1'000'000, 1'000'000'000,
                 sum_error, ~uint64_t(0)});
}

}  // namespace tilecast::stress
