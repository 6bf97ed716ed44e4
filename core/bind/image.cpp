#include "bind/bind.h"
#include "base/srgb.h"
#include "render/image.h"

using namespace tilecast;
using Metadata = std::map<std::string, std::string>;

namespace {

ImageInfo info_of(const py::array& pixels, const std::vector<std::string>& channels, const Metadata& metadata) {
  check_shape(pixels, {-1, -1, static_cast<py::ssize_t>(channels.size())}, "pixels");
  return {static_cast<int>(pixels.shape(1)), static_cast<int>(pixels.shape(0)), channels, metadata};
}

// Calls use(span of uint8 or float), by the array's type.
template <class Use>
auto with_pixels(const py::array& pixels, Use&& use) {
  if (pixels.dtype().is(py::dtype::of<uint8_t>())) {
    Array<uint8_t> bytes(pixels);
    return use(std::span<const uint8_t>(bytes.data(), bytes.size()));
  }
  Array<float> floats(pixels);
  return use(std::span<const float>(floats.data(), floats.size()));
}

// (pixels, channel names, metadata) of what `read` fills in.
template <class Read>
py::tuple read_by(Read&& read) {
  ImageInfo info;
  std::vector<float> pixels;
  {
    py::gil_scoped_release release;
    pixels = read(info);
  }
  py::ssize_t channels = static_cast<py::ssize_t>(info.channels.size());
  return py::make_tuple(to_array(std::move(pixels), {info.height, info.width, channels}), info.channels, info.metadata);
}

}  // namespace

void bind_image(py::module_& module) {
  module.def(
      "write_image",
      [](const std::string& path, const py::array& pixels, const std::vector<std::string>& channels,
         const Metadata& metadata) {
        ImageInfo info = info_of(pixels, channels, metadata);
        with_pixels(pixels, [&](auto span) {
          py::gil_scoped_release release;
          write_image(path, info, span);
        });
      },
      py::arg("path"), py::arg("pixels"), py::arg("channels"), py::arg("metadata") = Metadata{},
      "Writes pixels [h, w, c] as PNG (uint8) or EXR (float32), by the extension.");
  module.def(
      "encode_image",
      [](const std::string& format, const py::array& pixels, const std::vector<std::string>& channels,
         const Metadata& metadata) {
        ImageInfo info = info_of(pixels, channels, metadata);
        std::vector<uint8_t> bytes = with_pixels(pixels, [&](auto span) {
          py::gil_scoped_release release;
          return encode_image(format, info, span);
        });
        return py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
      },
      py::arg("format"), py::arg("pixels"), py::arg("channels"), py::arg("metadata") = Metadata{},
      "The bytes of pixels [h, w, c] as \"png\" (uint8) or \"exr\" (float32).");
  module.def(
      "read_image",
      [](const std::string& path) { return read_by([&](ImageInfo& info) { return read_image(path, info); }); },
      py::arg("path"), "(pixels [h, w, c] float32, channel names, metadata).");
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
  module.def(
      "decode_image",
      [](const std::string& name, const py::bytes& data, size_t most) {
        std::string_view view = data;
        std::span<const uint8_t> bytes(reinterpret_cast<const uint8_t*>(view.data()), view.size());
        return read_by([&](ImageInfo& info) { return decode_image(name, bytes, most, info); });
      },
      py::arg("name"), py::arg("data"), py::arg("most") = size_t(1) << 25,
      "The same from the bytes of a file of the format that the name's extension says; at most `most` pixels.");
}
