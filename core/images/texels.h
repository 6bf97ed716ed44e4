// Texels through OpenImageIO's TextureSystem.
//
// The pixels stay in memory, with 32 bits a channel and in linear light. The TextureSystem, one for the whole process,
// takes the tiles that it needs from them, keeps those within the limits of its cache, and interpolates at full
// resolution: rays have no footprint by which a smaller one could be chosen, and many samples a pixel average anyway. A
// lookup depends on the coordinates alone, not on threads or on what the cache holds.
#pragma once

#include <vector>

#include "scene/image_texture.h"

namespace tilecast {

// pixels: row by row from the top, 1 or 3 channels. Throws Error where sizes or values are out of range.
std::shared_ptr<Texels> make_texels(std::vector<float> pixels, int width, int height, int channels);

}  // namespace tilecast
