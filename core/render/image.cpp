#include "render/image.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include "base/error.h"

namespace tilecast {
namespace {

template <class T>
void write(const std::string& name, const ImageInfo& info, std::span<const T> pixels, OIIO::Filesystem::IOProxy* proxy) {
  auto output = OIIO::ImageOutput::create(name, proxy);
  if (!output) throw Error("cannot write " + name + ": " + OIIO::geterror());
  OIIO::TypeDesc type = OIIO::BaseTypeFromC<T>::value;
  OIIO::ImageSpec spec(info.width, info.height, static_cast<int>(info.channels.size()), type);
  spec.channelnames = info.channels;
  spec.attribute("compression", "zip");
  spec.attribute("oiio:ColorSpace", type == OIIO::TypeUInt8 ? "sRGB" : "Linear");
  for (const auto& [key, value] : info.metadata) spec.attribute(key, value);
  if (!output->open(name, spec) || !output->write_image(type, pixels.data()) || !output->close())
    throw Error("cannot write " + name + ": " + output->geterror());
}

template <class T>
std::vector<uint8_t> encode(const std::string& format, const ImageInfo& info, std::span<const T> pixels) {
  std::vector<unsigned char> bytes;
  OIIO::Filesystem::IOVecOutput proxy(bytes);
  write("image." + format, info, pixels, &proxy);
  return bytes;
}

}  // namespace

void write_image(const std::string& path, const ImageInfo& info, std::span<const uint8_t> pixels) {
  write(path, info, pixels, nullptr);
}
void write_image(const std::string& path, const ImageInfo& info, std::span<const float> pixels) {
  write(path, info, pixels, nullptr);
}
std::vector<uint8_t> encode_image(const std::string& format, const ImageInfo& info, std::span<const uint8_t> pixels) {
  return encode(format, info, pixels);
}
std::vector<uint8_t> encode_image(const std::string& format, const ImageInfo& info, std::span<const float> pixels) {
  return encode(format, info, pixels);
}

std::vector<float> read_image(const std::string& path, ImageInfo& info) {
  auto input = OIIO::ImageInput::open(path);
  if (!input) throw Error("cannot read " + path + ": " + OIIO::geterror());
  const OIIO::ImageSpec& spec = input->spec();
  info.width = spec.width;
  info.height = spec.height;
  info.channels = spec.channelnames;
  for (const auto& attribute : spec.extra_attribs) info.metadata[attribute.name().string()] = attribute.get_string();
  std::vector<float> pixels(size_t(spec.width) * spec.height * spec.nchannels);
  if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeFloat, pixels.data()))
    throw Error("cannot read " + path + ": " + input->geterror());
  return pixels;
}

}  // namespace tilecast
