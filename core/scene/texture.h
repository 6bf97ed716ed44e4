// Textures: colours, or the numbers in their first channel, as functions of the place on a surface.
#pragma once

#include <variant>

#include "scene/image_texture.h"

namespace tilecast {

// Where on a surface, as its object sees it.
struct TexturePoint {
  Vec3 point, normal;  // object space, metres; the normal of any length, outward
  Vec2 uv;             // see scene/parametrisation.h
};

// Cells of `size` in turn `even` and `odd`: cubes in object space, metres, or squares of the texture coordinates.
struct Checker {
  Rgb even{0.9}, odd{0.1};
  double size = 1.0;
  bool of_uv = false;
};

// From one colour to another along a coordinate, constant before and after.
struct Gradient {
  Rgb from{0.0}, to{1.0};
  int along = 4;                 // 0, 1, 2: x, y, z in object space, metres; 3, 4: u, v
  double start = 0.0, end = 1.0;
};

using Texture = std::variant<Checker, Gradient, ImageTexture>;

Rgb at(const Texture& texture, const TexturePoint& place);

bool needs_uv(const Texture& texture);

// Bounds of its values, by channel.
Rgb least(const Texture& texture);
Rgb most(const Texture& texture);

// Throws Error where a parameter cannot be.
void check(const Texture& texture);

}  // namespace tilecast
