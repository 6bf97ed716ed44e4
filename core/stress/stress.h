// Hazards as cases that can be run any number of times: what `tilecast stress` and the core's tests run.
//
// A case is a pure function of case numbers, so threads may share them out and any one can be looked at again.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace tilecast::stress {

enum class Combine : uint8_t { Sum, Max };  // of failures; of errors

struct Case {
  std::string name;     // short, in kebab-case
  int gate;             // the hazard's number in the README's table; 0: an extreme scene
  std::string figure;   // what is measured, with its unit: "leaks", "error, in 8 u of the extent"
  double limit;         // it holds while the figure is at most this
  Combine combine;
  uint64_t cases;       // a normal run
  uint64_t long_cases;  // with --long
  std::function<double(uint64_t first, uint64_t count)> run;  // the figure over cases first .. first + count - 1
};

struct Verdict {
  double figure = 0.0;
  uint64_t cases = 0;
  double seconds = 0.0;
  bool holds = false;
};

// All cases, in the order of their gates.
const std::vector<Case>& cases();

// Cases 0 .. count - 1, shared out among the threads.
Verdict run(const Case& stress_case, uint64_t count, int threads);

// One function for each family; each adds its cases.
void add_triangles(std::vector<Case>& out);

}  // namespace tilecast::stress
