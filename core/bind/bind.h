// Conversions shared by the bindings.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <array>
#include <string>
#include <vector>

#include "base/affine.h"

namespace py = pybind11;

using Triple = std::array<double, 3>;
template <class T>
using Array = py::array_t<T, py::array::c_style | py::array::forcecast | py::detail::npy_api::NPY_ARRAY_ALIGNED_>;

inline tilecast::Vec3 to_vec(const Triple& t) { return {t[0], t[1], t[2]}; }

// Refuses an array of another shape; -1 stands for any length.
inline void check_shape(const py::array& array, const std::vector<py::ssize_t>& shape, const char* name) {
  bool right = array.ndim() == static_cast<py::ssize_t>(shape.size());
  std::string wanted, got;
  py::ssize_t i = 0;
  for (py::ssize_t n : shape) {
    right = right && (n < 0 || array.shape(i) == n);
    wanted.append(i++ ? ", " : "").append(n < 0 ? "n" : std::to_string(n));
  }
  if (right) return;
  for (i = 0; i < array.ndim(); ++i) got.append(i ? ", " : "").append(std::to_string(array.shape(i)));
  throw py::value_error(std::string(name) + ": must have shape [" + wanted + "], got [" + got + "]");
}

// Hands a vector's memory to numpy.
template <class T>
py::array_t<T> to_array(std::vector<T>&& values, std::vector<py::ssize_t> shape) {
  auto* owner = new std::vector<T>(std::move(values));
  py::capsule free(owner, [](void* p) { delete static_cast<std::vector<T>*>(p); });
  return py::array_t<T>(std::move(shape), owner->data(), free);
}

namespace tilecast {
struct Scene;
}
using SceneClass = py::class_<tilecast::Scene, std::shared_ptr<tilecast::Scene>>;

void bind_scene(py::module_& module);
void bind_queries(py::module_& module, SceneClass& scene);
void bind_camera(py::module_& module);
void bind_builder(py::module_& module);
void bind_error(py::module_& module);
void bind_colour(py::module_& module);
void bind_stress(py::module_& module);
