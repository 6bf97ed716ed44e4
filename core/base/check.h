// What parameters must hold; errors begin with the parameter's name.
#pragma once

#include <cmath>
#include <cstdio>
#include <string>

#include "base/error.h"

namespace tilecast {

inline std::string text(double x) {
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, "%g", x);
  return buffer;
}

// Lengths lie in a range in which no product of a few overflows.
inline constexpr double kShortest = 1e-100, kLongest = 1e100;

inline void check_length(double x, const char* name) {
  if (!(x >= kShortest && x <= kLongest))
    throw Error(std::string(name) + ": must lie between 1e-100 and 1e100, got " + text(x));
}

inline void check_positive(double x, const char* name) {
  if (!(x > 0.0)) throw Error(std::string(name) + ": must be positive, got " + text(x));
  check_length(x, name);
}

}  // namespace tilecast
