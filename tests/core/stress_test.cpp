// Every hazard, run as often as a normal `tilecast stress` does; with sanitizers, a twentieth of that and a few
// thousand times at most.
#include <gtest/gtest.h>

#include "stress/stress.h"

namespace tilecast::stress {
namespace {

#ifdef __SANITIZE_ADDRESS__
constexpr uint64_t kMost = 8192, kShare = 20;
#else
constexpr uint64_t kMost = ~uint64_t(0), kShare = 1;
#endif

constexpr uint64_t kFewest = 18;

class Hazard : public ::testing::TestWithParam<size_t> {};

TEST_P(Hazard, Holds) {
  const Case& hazard = cases()[GetParam()];
  Verdict verdict = run(hazard, 0, std::min(std::max(hazard.cases / kShare, std::min(hazard.cases, kFewest)), kMost), 1);
  EXPECT_TRUE(verdict.holds) << hazard.name << ": " << hazard.figure << " " << verdict.figure << ", limit " << hazard.limit << "; "
                             << verdict.error;
}

INSTANTIATE_TEST_SUITE_P(All, Hazard, ::testing::Range(size_t(0), cases().size()), [](const auto& info) {
  std::string name = cases()[info.param].name;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

}  // namespace
}  // namespace tilecast::stress
