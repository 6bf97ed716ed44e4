#include "stress/stress.h"

#include "bind/bind.h"

using namespace tilecast::stress;

namespace {

const Case& find(const std::string& name) {
  for (const Case& c : cases())
    if (c.name == name) return c;
  throw tilecast::Error("no case is called " + name);
}

std::pair<Verdict, bool> run_case(const std::string& name, uint64_t first, uint64_t end, int threads) {
  const Case& found = find(name);
  if (first > end || first % found.batch != 0)
    throw tilecast::Error("first: must be a multiple of " + std::to_string(found.batch) + " up to the number of cases");
  bool interrupted = false;
  Verdict verdict;
  {
    py::gil_scoped_release release;
    verdict = run(found, first, end, threads, [&](uint64_t) {
      py::gil_scoped_acquire acquire;
      interrupted = PyErr_CheckSignals() != 0;  // Ctrl-C
      return !interrupted;
    });
  }
  if (interrupted && !PyErr_ExceptionMatches(PyExc_KeyboardInterrupt)) throw py::error_already_set();
  PyErr_Clear();
  return {verdict, interrupted};
}

}  // namespace

void bind_stress(py::module_& module) {
  py::class_<Case>(module, "StressCase", "A hazard that can be run any number of times.")
      .def_readonly("name", &Case::name)
      .def_readonly("gate", &Case::gate, "Its number in the table of hazards; 0: an extreme scene.")
      .def_readonly("figure", &Case::figure, "What is measured, with its unit.")
      .def_readonly("limit", &Case::limit, "It holds while the figure is at most this.")
      .def_readonly("cases", &Case::cases, "A normal run.")
      .def_readonly("long_cases", &Case::long_cases)
      .def_readonly("batch", &Case::batch, "A run may begin at its multiples.");
  py::class_<Verdict>(module, "StressVerdict", "How a case came out.")
      .def_readonly("figure", &Verdict::figure)
      .def_readonly("cases", &Verdict::cases, "That were run.")
      .def_readonly("seconds", &Verdict::seconds)
      .def_readonly("holds", &Verdict::holds)
      .def_readonly("error", &Verdict::error, "What the core refused or threw; empty where all is well.")
      .def_property_readonly("build_seconds", [](const Verdict& v) { return v.costs.build_seconds; }, "0: it has no scene of its own.")
      .def_property_readonly("bytes", [](const Verdict& v) { return v.costs.bytes; }, "Of the scene's accelerators.")
      .def_property_readonly("rays_per_second", [](const Verdict& v) { return v.costs.rays_per_second; }, "Closest hits, one thread.");
  module.def("stress_cases", &cases, "All cases, in the order of their gates; then the extreme scenes.");
  module.def("run_stress", &run_case, py::arg("name"), py::arg("first"), py::arg("end"), py::arg("threads"),
             "Runs cases first .. end - 1, shared out among threads, with the GIL released. (verdict, whether Ctrl-C ended it): then "
             "all before first + verdict.cases have been run, and no others.");
}
