// What builders sort into nodes and cells that a primitive may stand in several of.
#pragma once

#include <vector>

#include "accel/frame_box.h"

namespace tilecast {

// A primitive, or the part of one that lies in a node's or a cell's region.
struct Reference {
  FrameBox box;  // padded, of the part
  uint32_t primitive;
};
using References = std::vector<Reference>;

inline References references_to(const PrimitiveSet& primitives) {
  References out(primitives.size());
  for (uint32_t i = 0; i < out.size(); ++i) out[i] = {primitives.boxes[i], i};
  return out;
}

// A node that still has to be built, of a tree that parts space.
struct CellTask {
  uint32_t node;
  int depth;
  double allowed;  // references below
  FrameBox cell;
  References items;

  static CellTask root(const PrimitiveSet& primitives) {
    constexpr double kMostReferences = 8.0;  // for each primitive
    return {0, 1, kMostReferences * primitives.size(), primitives.bounds(), references_to(primitives)};
  }
};

}  // namespace tilecast
