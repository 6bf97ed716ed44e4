#include "base/guide.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace tilecast {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

size_t searched(const std::vector<double>& ascending, double value) {
  return std::upper_bound(ascending.begin(), ascending.end(), value) - ascending.begin();
}

TEST(Guide, FindsWhatABinarySearchFinds) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int k = 0; k < 5000; ++k) {
    std::vector<double> numbers(random() % 50);
    for (double& number : numbers) {
      number = uniform(random);
      switch (random() % 5) {  // alike, tiny, crowded, far away
        case 0: number = std::floor(4.0 * number); break;
        case 1: number *= 1e-310; break;
        case 2: number = 0.7 + 1e-12 * number; break;
        case 3: number *= 1e300; break;
      }
    }
    std::sort(numbers.begin(), numbers.end());
    const Guide guide(numbers, 1 + random() % 100);
    for (int i = 0; i < 100; ++i) {
      double value = 2.0 * uniform(random) - 0.5;
      if (!numbers.empty() && random() % 2) value = numbers[random() % numbers.size()];
      if (random() % 4 == 0) value = std::nextafter(value, random() % 2 ? kInf : -kInf);
      ASSERT_EQ(guide.above(numbers.data(), value), searched(numbers, value)) << value;
    }
    for (double value : {-kInf, kInf, 0.0, -0.0})
      ASSERT_EQ(guide.above(numbers.data(), value), searched(numbers, value)) << value;
  }
}

TEST(Guide, HasNothingToFindInNothing) { EXPECT_EQ(Guide().above(nullptr, 1.0), 0u); }

}  // namespace
}  // namespace tilecast
