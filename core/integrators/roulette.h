// When paths that carry little are ended: Arvo and Kirk, "Particle Transport and Image Synthesis", SIGGRAPH 1990.
#pragma once

namespace tilecast {

inline constexpr int kRouletteDepth = 4;  // path segments that are never cut short

}  // namespace tilecast
