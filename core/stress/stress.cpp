#include "stress/stress.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>

namespace tilecast::stress {
namespace {
constexpr uint64_t kBatch = 4096;
}

const std::vector<Case>& cases() {
  static const std::vector<Case> all = [] {
    std::vector<Case> out;
    add_triangles(out);
    std::stable_sort(out.begin(), out.end(), [](const Case& a, const Case& b) {
      return (a.gate ? a.gate : 1000) < (b.gate ? b.gate : 1000);
    });
    return out;
  }();
  return all;
}

Verdict run(const Case& stress_case, uint64_t count, int threads) {
  auto start = std::chrono::steady_clock::now();
  std::atomic<uint64_t> next{0};
  std::mutex mutex;
  Verdict verdict;
  auto work = [&] {
    for (;;) {
      uint64_t first = next.fetch_add(kBatch);
      if (first >= count) return;
      double figure = stress_case.run(first, std::min(kBatch, count - first));
      std::lock_guard lock(mutex);
      if (stress_case.combine == Combine::Sum) {
        verdict.figure += figure;
      } else if (!(figure <= verdict.figure)) {  // NaN stays
        verdict.figure = figure;
      }
    }
  };
  std::vector<std::jthread> pool;
  for (int i = 1; i < threads; ++i) pool.emplace_back(work);
  work();
  pool.clear();
  verdict.cases = count;
  verdict.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  verdict.holds = verdict.figure <= stress_case.limit;
  return verdict;
}

}  // namespace tilecast::stress
