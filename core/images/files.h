// Images in and out through OpenImageIO. Interleaved rows from the top, channels innermost.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace tilecast {

struct ImageInfo {
  int width = 0, height = 0;
  std::vector<std::string> channels;
  std::map<std::string, std::string> metadata;
};

// As PNG (8 bit) or EXR (float, ZIP), by the extension of the path.
void write_image(const std::string& path, const ImageInfo& info, std::span<const uint8_t> pixels);
void write_image(const std::string& path, const ImageInfo& info, std::span<const float> pixels);

// The same in memory; format: png or exr.
std::vector<uint8_t> encode_image(const std::string& format, const ImageInfo& info, std::span<const uint8_t> pixels);
std::vector<uint8_t> encode_image(const std::string& format, const ImageInfo& info, std::span<const float> pixels);

// Values as float; 8-bit ones lie in [0, 1].
std::vector<float> read_image(const std::string& path, ImageInfo& info);
// The same from memory: a file of the format that the name's extension says. Refuses more than `most` pixels.
std::vector<float> decode_image(const std::string& name, std::span<const uint8_t> bytes, size_t most, ImageInfo& info);

}  // namespace tilecast
