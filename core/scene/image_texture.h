// An image as a function of texture coordinates.
//
// Its texels are looked up by another library, images/, that scenes without images do not load: OpenImageIO and what it
// needs are larger than all else together.
#pragma once

#include <memory>

#include "base/vec.h"

namespace tilecast {

enum class Wrap : uint8_t { Repeat, Mirror, Clamp };
enum class TexelFilter : uint8_t { Bilinear, Closest };

// What several textures may share: pixels that cover the unit square.
class Texels {
 public:
  virtual ~Texels() = default;
  // At (s, t), t upwards, each in [0, 1], or in [0, 2] where it is mirrored. A single channel stands for all three.
  virtual Rgb at(const Vec2& st, Wrap wrap, TexelFilter filter) const = 0;

  Rgb least{0.0}, most{0.0};  // of each channel
};

class ImageTexture {
 public:
  // The image covers the unit square of `tiling` (u, v) + `offset`, with v upwards.
  ImageTexture(std::shared_ptr<const Texels> texels, Wrap wrap, TexelFilter filter, const Vec2& tiling, const Vec2& offset);

  Rgb at(const Vec2& uv) const;

  // The least and the greatest value of each channel.
  Rgb least() const { return texels_->least; }
  Rgb most() const { return texels_->most; }

 private:
  std::shared_ptr<const Texels> texels_;
  Wrap wrap_;
  TexelFilter filter_;
  Vec2 tiling_, offset_;
};

}  // namespace tilecast
