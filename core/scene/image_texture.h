// An image as a function of texture coordinates, through OpenImageIO's TextureSystem.
//
// The pixels stay in memory, with 32 bits a channel and in linear light. The TextureSystem, one for the whole process,
// takes the tiles that it needs from them, keeps those within the limits of its cache, and interpolates at full
// resolution: rays have no footprint by which a smaller one could be chosen, and many samples a pixel average anyway. A
// lookup depends on the coordinates alone, not on threads or on what the cache holds.
#pragma once

#include <memory>
#include <vector>

#include "base/vec.h"

namespace tilecast {

enum class Wrap : uint8_t { Repeat, Mirror, Clamp };
enum class TexelFilter : uint8_t { Bilinear, Closest };

class ImageTexture {
 public:
  // What is stored, shared by all textures of one image.
  class Image;
  // pixels: row by row from the top, 1 or 3 channels. Throws Error where sizes or values are out of range.
  static std::shared_ptr<const Image> store(std::vector<float> pixels, int width, int height, int channels);

  // The image covers the unit square of `tiling` (u, v) + `offset`, with v upwards.
  ImageTexture(std::shared_ptr<const Image> image, Wrap wrap, TexelFilter filter, const Vec2& tiling, const Vec2& offset);

  // A single channel stands for all three.
  Rgb at(const Vec2& uv) const;

  // The least and the greatest value of each channel.
  Rgb least() const;
  Rgb most() const;

 private:
  std::shared_ptr<const Image> image_;
  Wrap wrap_;
  TexelFilter filter_;
  Vec2 tiling_, offset_;
};

}  // namespace tilecast
