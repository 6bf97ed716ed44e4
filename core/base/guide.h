// Where a value lies among numbers in ascending order, in constant time on average.
//
// Chen and Asau, "On Generating Random Variates from an Empirical Distribution", AIIE Transactions 6(2), 1974: the range
// of the numbers is cut into equal cells, and a table says which numbers lie in each. Only those are searched. What is
// found is what std::upper_bound finds: a value's cell never falls as the value grows, whatever the rounding.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace tilecast {

class Guide {
 public:
  Guide() = default;
  Guide(std::span<const double> ascending, size_t cells) : last_(static_cast<double>(cells - 1)), first_() {
    if (!ascending.empty() && ascending.back() > ascending.front()) {
      low_ = ascending.front();
      scale_ = static_cast<double>(cells) / (ascending.back() - low_);
    }
    first_.reserve(cells + 1);
    for (size_t i = 0; i < ascending.size(); ++i)
      while (first_.size() <= cell(ascending[i])) first_.push_back(static_cast<uint32_t>(i));
    first_.resize(cells + 1, static_cast<uint32_t>(ascending.size()));
  }

  // The index of the first number above `value`; how many there are, where none is. `ascending`: those it was made of.
  size_t above(const double* ascending, double value) const {
    const uint32_t* const range = &first_[cell(value)];
    return std::upper_bound(ascending + range[0], ascending + range[1], value) - ascending;
  }

 private:
  size_t cell(double value) const {  // 0 for NaN
    return static_cast<size_t>(std::max(0.0, std::min((value - low_) * scale_, last_)));
  }

  double low_ = 0.0, scale_ = 0.0, last_ = 0.0;
  std::vector<uint32_t> first_{0, 0};  // number of each cell; and how many there are
};

}  // namespace tilecast
