#include "scene/image_texture.h"

#include <utility>

namespace tilecast {

ImageTexture::ImageTexture(std::shared_ptr<const Texels> texels, Wrap wrap, TexelFilter filter, const Vec2& tiling,
                           const Vec2& offset)
    : texels_(std::move(texels)), wrap_(wrap), filter_(filter), tiling_(tiling), offset_(offset) {}

Rgb ImageTexture::at(const Vec2& uv) const {
  // Near 0 before they become float, where far away ones would lose their digits.
  Vec2 st = uv * tiling_ + offset_;
  switch (wrap_) {
    case Wrap::Repeat: st -= glm::floor(st); break;
    case Wrap::Mirror: st -= 2.0 * glm::floor(0.5 * st); break;
    case Wrap::Clamp: st = glm::clamp(st, 0.0, 1.0); break;
  }
  // Weights add up to 1 but for rounding, which is not to make anything brighter than the image is.
  return glm::clamp(texels_->at(st, wrap_, filter_), least(), most());
}

}  // namespace tilecast
