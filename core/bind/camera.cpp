#include "bind/bind.h"
#include "scene/camera.h"

using namespace tilecast;

namespace {

View view_of(const Triple& position, const Triple& target, const Triple& up, int width, int height) {
  return {to_vec(position), to_vec(target), to_vec(up), width, height};
}

}  // namespace

void bind_camera(py::module_& module) {
  py::class_<View>(module, "View", "Where a camera stands, and its image in pixels.")
      .def(py::init(&view_of), py::arg("position"), py::arg("target"), py::arg("up"), py::arg("width"), py::arg("height"));
  py::class_<Camera>(module, "Camera", "What image points see. fov: degrees across the image's height; lengths in metres.")
      .def_static("perspective", &Camera::perspective, py::arg("view"), py::arg("fov"))
      .def_static("orthographic", &Camera::orthographic, py::arg("view"), py::arg("height"))
      .def_static("thin_lens", &Camera::thin_lens, py::arg("view"), py::arg("fov"), py::arg("aperture"),
                  py::arg("focus_distance"))
      .def_static("panorama", &Camera::panorama, py::arg("view"));
}
