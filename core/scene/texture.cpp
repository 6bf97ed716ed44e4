#include "scene/texture.h"

#include "base/built.h"
#include "base/check.h"

namespace tilecast {
namespace {

// A point on the wall between two cells may fall on either side; those of surfaces that lie in a wall must not.
Rgb at(const Checker& c, const TexturePoint& place) {
  // A step inwards keeps faces that lie on a wall in one cell.
  const Vec3 p = c.of_uv ? Vec3(place.uv, 0.0) : place.point - 1e-6 * c.size * glm::normalize(place.normal);
  const Vec3 cell = glm::floor(p / c.size);
  const double parity = cell.x + cell.y + cell.z;
  return parity - 2.0 * std::floor(0.5 * parity) == 0.0 ? c.even : c.odd;
}

Rgb at(const Gradient& g, const TexturePoint& place) {
  const double x = g.along < 3 ? place.point[g.along] : place.uv[g.along - 3];
  const double t = std::clamp((x - g.start) / (g.end - g.start), 0.0, 1.0);
  return glm::clamp(g.from + t * (g.to - g.from), glm::min(g.from, g.to), glm::max(g.from, g.to));
}

Rgb at(const ImageTexture& image, const TexturePoint& place) { return image.at(place.uv); }

template <class... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};

}  // namespace

Rgb at(const Texture& texture, const TexturePoint& place) {
  if (!built_with("image_texture") && std::holds_alternative<ImageTexture>(texture)) __builtin_unreachable();
  return std::visit([&](const auto& t) { return at(t, place); }, texture);
}

bool needs_uv(const Texture& texture) {
  return std::visit(Overloaded{[](const Checker& c) { return c.of_uv; }, [](const Gradient& g) { return g.along >= 3; },
                               [](const ImageTexture&) { return true; }},
                    texture);
}

Rgb least(const Texture& texture) {
  return std::visit(Overloaded{[](const Checker& c) { return glm::min(c.even, c.odd); },
                               [](const Gradient& g) { return glm::min(g.from, g.to); },
                               [](const ImageTexture& i) { return i.least(); }},
                    texture);
}

Rgb most(const Texture& texture) {
  return std::visit(Overloaded{[](const Checker& c) { return glm::max(c.even, c.odd); },
                               [](const Gradient& g) { return glm::max(g.from, g.to); },
                               [](const ImageTexture& i) { return i.most(); }},
                    texture);
}

void check(const Texture& texture) {
  if (const Checker* c = std::get_if<Checker>(&texture)) check_positive(c->size, "size");
  if (const Gradient* g = std::get_if<Gradient>(&texture)) {
    if (!(std::fabs(g->start) <= kLongest && std::fabs(g->end) <= kLongest && g->start != g->end &&
          std::fabs(g->end - g->start) >= kShortest))
      throw Error("range: must be two different numbers of at most 1e100");
  }
}

}  // namespace tilecast
