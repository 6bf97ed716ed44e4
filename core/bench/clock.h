// What a piece of work takes.
#pragma once

#include <ctime>

namespace tilecast::bench {

// With one thread the processor's time, so that what else runs on the machine disturbs less; with more, the clock's.
template <class Work>
double seconds(int threads, Work&& work) {
  auto now = [&] {
    timespec t;
    clock_gettime(threads == 1 ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_MONOTONIC, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  };
  const double start = now();
  work();
  return now() - start;
}

}  // namespace tilecast::bench
