// tilecast._images: what needs OpenImageIO, apart from the core so that nothing loads it before there is an image to read,
// to write or to look up. No logic.
#include "base/error.h"
#include "bind/bind.h"
#include "images/files.h"
#include "images/texels.h"

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

// An image as the texels of textures.
std::shared_ptr<Texels> texels_of(const Array<float>& pixels) {
  const int channels = pixels.ndim() == 3 && pixels.shape(2) == 1 ? 1 : 3;
  check_shape(pixels, {-1, -1, channels}, "pixels");
  std::vector<float> copy(pixels.data(), pixels.data() + pixels.size());
  const int width = static_cast<int>(pixels.shape(1)), height = static_cast<int>(pixels.shape(0));
  py::gil_scoped_release release;
  return make_texels(std::move(copy), width, height, channels);
}

}  // namespace

PYBIND11_MODULE(_images, module) {
  module.doc() = "Image files and the texels of textures, through OpenImageIO.";
  py::module_::import("tilecast._core");  // which has the class of texels and the exception
  py::register_local_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Error& error) {
      py::set_error(py::module_::import("tilecast._core").attr("Error"), error.what());
    }
  });
  module.def(
      "write",
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
      "encode",
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
      "read",
      [](const std::string& path) { return read_by([&](ImageInfo& info) { return read_image(path, info); }); },
      py::arg("path"), "(pixels [h, w, c] float32, channel names, metadata).");
  module.def(
      "decode",
      [](const std::string& name, const py::bytes& data, size_t most) {
        std::string_view view = data;
        std::span<const uint8_t> bytes(reinterpret_cast<const uint8_t*>(view.data()), view.size());
        return read_by([&](ImageInfo& info) { return decode_image(name, bytes, most, info); });
      },
      py::arg("name"), py::arg("data"), py::arg("most") = size_t(1) << 25,
      "The same from the bytes of a file of the format that the name's extension says; at most `most` pixels.");
  module.def("texels", &texels_of, py::arg("pixels"),
             "What textures may share: float32 [h, w, 1 or 3], rows from the top; linear light, or plain numbers.");
}
