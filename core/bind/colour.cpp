#include "base/srgb.h"
#include "bind/bind.h"

using namespace tilecast;

void bind_colour(py::module_& module) {
  module.def(
      "linear",
      [](const Array<float>& values) {
        std::vector<float> out(values.data(), values.data() + values.size());
        {
          py::gil_scoped_release release;
          for (float& value : out) value = srgb_to_linear(value);
        }
        return to_array(std::move(out), {values.shape(), values.shape() + values.ndim()});
      },
      py::arg("values"), "sRGB in 0 to 1 as linear light: float32, of the same shape; the same bits on every machine.");
}
