// Cases of `tilecast stress` without Python, for an emulated machine: see tests/emulated/run.
//
//     cases CASE=COUNT...
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "stress/stress.h"

int main(int argc, char** argv) {
  using namespace tilecast::stress;
  bool all = true;
  for (int i = 1; i < argc; ++i) {
    const char* count = std::strchr(argv[i], '=');
    bool found = false;
    for (const Case& stress_case : cases()) {
      if (count == nullptr || stress_case.name != std::string_view(argv[i], count - argv[i])) continue;
      found = true;
      const Verdict verdict = run(stress_case, 0, std::strtoull(count + 1, nullptr, 10), 1);
      std::printf("%5d  %-21s %-7s %12llu  %.3g %s%s\n", stress_case.gate, stress_case.name.c_str(), verdict.holds ? "holds" : "FAILS",
                  static_cast<unsigned long long>(verdict.cases), verdict.figure, stress_case.figure.c_str(), verdict.error.c_str());
      std::fflush(stdout);
      all = all && verdict.holds;
    }
    if (!found) std::printf("no case %s\n", argv[i]);
    all = all && found;
  }
  std::puts(all ? "all hold" : "not all hold");
  return all ? 0 : 1;
}
