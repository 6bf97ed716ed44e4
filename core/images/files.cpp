#include "images/files.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <limits>

#include "base/error.h"

namespace tilecast {
namespace {

constexpr int kMostChannels = 64;

template <class T>
void write(const std::string& name, const ImageInfo& info, std::span<const T> pixels, OIIO::Filesystem::IOProxy* proxy) {
  auto output = OIIO::ImageOutput::create(name, proxy);
  if (!output) throw Error("cannot write " + name + ": " + OIIO::geterror());
  OIIO::TypeDesc type = OIIO::BaseTypeFromC<T>::value;
  OIIO::ImageSpec spec(info.width, info.height, static_cast<int>(info.channels.size()), type);
  spec.channelnames = info.channels;
  spec.attribute("compression", "zip");
  spec.attribute("oiio:ColorSpace", type == OIIO::TypeUInt8 ? "sRGB" : "Linear");
  spec.attribute("DateTime", "");  // or it is the present second, and the same image makes another file a second later
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

std::vector<float> read(const std::string& name, OIIO::Filesystem::IOProxy* proxy, size_t most, ImageInfo& info) {
  OIIO::ImageSpec wanted;
  wanted.attribute("oiio:UnassociatedAlpha", 1);  // colours as the file has them, not multiplied by its alpha channel
  if (proxy) wanted.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);  // beside settings, it is looked for among them
  auto input = OIIO::ImageInput::open(name, &wanted, proxy);
  if (!input) throw Error("cannot read " + name + ": " + OIIO::geterror());
  const OIIO::ImageSpec& spec = input->spec();
  if (spec.width < 1 || spec.height < 1 || spec.depth > 1 || spec.nchannels < 1 ||
      spec.nchannels > kMostChannels)
    throw Error("cannot read " + name + ": it is no flat image of 1 to " + std::to_string(kMostChannels) + " channels");
  if (size_t(spec.width) * spec.height > most)
    throw Error("cannot read " + name + ": it has " + std::to_string(spec.width) + " x " + std::to_string(spec.height) +
                " pixels, more than " + std::to_string(most));
  info.width = spec.width;
  info.height = spec.height;
  info.channels = spec.channelnames;
  for (const auto& attribute : spec.extra_attribs) info.metadata[attribute.name().string()] = attribute.get_string();
  std::vector<float> pixels(size_t(spec.width) * spec.height * spec.nchannels);
  if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeFloat, pixels.data()))
    throw Error("cannot read " + name + ": " + input->geterror());
  return pixels;
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
  return read(path, nullptr, std::numeric_limits<size_t>::max(), info);
}

std::vector<float> decode_image(const std::string& name, std::span<const uint8_t> bytes, size_t most, ImageInfo& info) {
  OIIO::Filesystem::IOMemReader proxy(const_cast<uint8_t*>(bytes.data()), bytes.size());  // it only reads
  return read(name, &proxy, most, info);
}

}  // namespace tilecast
