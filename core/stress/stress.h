// Hazards as cases that can be run any number of times: what `tilecast stress` and the core's tests run.
//
// A case is a pure function of case numbers, so threads may share them out and any one can be looked at again.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "stress/random.h"

namespace tilecast::stress {

enum class Combine : uint8_t { Sum, Max };  // of failures; of errors

// What an extreme scene costs; zeros where a case has no scene of its own.
struct Costs {
  double build_seconds = 0.0;
  uint64_t bytes = 0;  // of its accelerators
  double rays_per_second = 0.0;  // closest hits, one thread
};

struct Case {
  std::string name;     // short, in kebab-case
  int gate;             // the hazard's number in the README's table; 0: an extreme scene
  std::string figure;   // what is measured, with its unit: "leaks", "error, in 8 u of the extent"
  double limit;         // it holds while the figure is at most this
  Combine combine;
  uint64_t cases;       // a normal run
  uint64_t long_cases;  // with --long
  std::function<double(uint64_t first, uint64_t count)> run;  // the figure over cases first .. first + count - 1
  uint64_t batch = 4096;  // how many cases go into a call of `run`; calls start at its multiples
  std::function<Costs()> costs = nullptr;
};

struct Verdict {
  double figure = 0.0;
  uint64_t cases = 0;   // that were run
  double seconds = 0.0;
  bool holds = false;
  std::string error;    // what the core threw; nothing, where all is well
  Costs costs;
};

// All cases, in the order of their gates.
const std::vector<Case>& cases();

// Looked at by the calling thread between its batches, with the number of cases begun; false ends the run early.
using KeepGoing = std::function<bool(uint64_t begun)>;

// Cases first .. end - 1, shared out among the threads; `first` is a multiple of the case's batch. Of a run that was ended early
// all cases before first + Verdict::cases have been run, and no others.
Verdict run(const Case& stress_case, uint64_t first, uint64_t end, int threads, const KeepGoing& keep_going = nullptr);

// The figure of a batch from that of its cases, case_figure(random, i). The random numbers follow from `first`.
template <class CaseFigure>
double sum_over(uint64_t first, uint64_t count, CaseFigure&& case_figure) {
  Random random(first);
  double sum = 0.0;
  for (uint64_t i = first; i < first + count; ++i) sum += case_figure(random, i);
  return sum;
}
template <class CaseFigure>
double worst_over(uint64_t first, uint64_t count, CaseFigure&& case_figure) {
  Random random(first);
  double worst = 0.0;
  for (uint64_t i = first; i < first + count; ++i) {
    double figure = case_figure(random, i);
    if (!(figure <= worst)) worst = figure;  // NaN stays
  }
  return worst;
}
// Sums cases that share, `share` in a row, what draw(random, the row's number) brings about.
template <class Draw, class CaseFigure>
double sum_over_rows(uint64_t first, uint64_t count, uint64_t share, Draw&& draw, CaseFigure&& case_figure) {
  return sum_over(first, count, [&](Random& random, uint64_t i) {
    if (i == first || i % share == 0) draw(random, i / share);
    return case_figure(random, i);
  });
}
// The same, as a case's `run`.
template <class CaseFigure>
auto sum_of(CaseFigure case_figure) {
  return [case_figure](uint64_t first, uint64_t count) { return sum_over(first, count, case_figure); };
}
template <class CaseFigure>
auto worst_of(CaseFigure case_figure) {
  return [case_figure](uint64_t first, uint64_t count) { return worst_over(first, count, case_figure); };
}

// One function for each family; each adds its cases.
void add_triangles(std::vector<Case>& out);
void add_slivers(std::vector<Case>& out);
void add_boxes(std::vector<Case>& out);
void add_agreement(std::vector<Case>& out);
void add_crowding(std::vector<Case>& out);
void add_spawned_rays(std::vector<Case>& out);
void add_scaling(std::vector<Case>& out);
void add_coplanar(std::vector<Case>& out);
void add_trees(std::vector<Case>& out);
void add_chains(std::vector<Case>& out);
void add_instances(std::vector<Case>& out);
void add_threads(std::vector<Case>& out);
void add_extreme_geometry(std::vector<Case>& out);
void add_extreme_light(std::vector<Case>& out);
void add_solids(std::vector<Case>& out);
void add_dielectrics(std::vector<Case>& out);
void add_scattering(std::vector<Case>& out);
void add_samples(std::vector<Case>& out);
void add_long_sums(std::vector<Case>& out);

}  // namespace tilecast::stress
