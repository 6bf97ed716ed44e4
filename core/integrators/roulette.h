// When paths that carry little are ended: Arvo and Kirk, "Particle Transport and Image Synthesis", SIGGRAPH 1990.
#pragma once

namespace tilecast {

inline constexpr int kRouletteDepth = 4;  // path segments that are never cut short

// A path goes on with a probability of what it carries times this, at most 1. Of 1, 1.5, 2, 3 and infinity, 2 has the
// least product of error and rays in the Cornell box, 7 % less than 1.
inline constexpr double kRouletteScale = 2.0;

}  // namespace tilecast
