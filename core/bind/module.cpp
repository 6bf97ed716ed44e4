// tilecast._core: the core's classes as they are, over numpy arrays. No logic.
#include "bind/bind.h"

#include "base/error.h"

PYBIND11_MODULE(_core, module) {
  module.doc() = "Tilecast's ray-tracing core.";
  py::register_exception<tilecast::Error>(module, "Error", PyExc_ValueError);
  py::register_exception<tilecast::SampleError>(module, "SampleError", PyExc_RuntimeError);
  bind_scene(module);
  bind_camera(module);
  bind_builder(module);
  bind_error(module);
  bind_colour(module);
  bind_stress(module);
}
