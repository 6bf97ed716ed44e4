#include "stress/stress.h"

#include <atomic>
#include <chrono>
#include <exception>
#include <mutex>
#include <thread>

namespace tilecast::stress {

const std::vector<Case>& cases() {
  static const std::vector<Case> all = [] {
    std::vector<Case> out;
    for (auto* add : {add_triangles, add_slivers, add_boxes, add_agreement, add_crowding, add_spawned_rays, add_scaling,
                      add_solids, add_coplanar, add_trees, add_chains, add_instances, add_threads, add_extreme_geometry,
                      add_extreme_light, add_dielectrics, add_scattering, add_samples, add_long_sums})
      add(out);
    std::stable_sort(out.begin(), out.end(), [](const Case& a, const Case& b) {
      return (a.gate ? a.gate : 1000) < (b.gate ? b.gate : 1000);
    });
    return out;
  }();
  return all;
}

Verdict run(const Case& stress_case, uint64_t first_case, uint64_t end, int threads, const KeepGoing& keep_going) {
  auto start = std::chrono::steady_clock::now();
  std::atomic<uint64_t> next{first_case};
  std::atomic<bool> stop{false};
  std::mutex mutex;
  Verdict verdict;
  auto work = [&](bool caller) {
    while (!stop) {
      uint64_t first = next.fetch_add(stress_case.batch);
      if (first >= end) return;
      uint64_t share = std::min(stress_case.batch, end - first);
      try {
        double figure = stress_case.run(first, share);
        std::lock_guard lock(mutex);
        verdict.cases += share;
        if (stress_case.combine == Combine::Sum) {
          verdict.figure += figure;
        } else if (!(figure <= verdict.figure)) {  // NaN stays
          verdict.figure = figure;
        }
      } catch (const std::exception& error) {
        std::lock_guard lock(mutex);
        verdict.error = error.what();
        stop = true;
      }
      if (caller && keep_going && !keep_going(std::min<uint64_t>(next, end))) stop = true;
    }
  };
  {
    std::vector<std::jthread> pool;
    for (int i = 1; i < threads; ++i) pool.emplace_back(work, false);
    work(true);
  }
  verdict.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  verdict.holds = verdict.figure <= stress_case.limit && verdict.cases == end - first_case && verdict.error.empty();
  if (stress_case.costs && !stop) verdict.costs = stress_case.costs();
  return verdict;
}

}  // namespace tilecast::stress
