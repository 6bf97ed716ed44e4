// Float boxes in a frame, and what an accelerator is built over.
#pragma once

#include <span>

#include "accel/clip_triangle.h"
#include "geometry/mesh.h"

namespace tilecast {

struct FrameBox {
  static constexpr float kFar = std::numeric_limits<float>::infinity();
  float lo[3] = {kFar, kFar, kFar}, hi[3] = {-kFar, -kFar, -kFar};

  // Of a triangle, padded by kBoxPadding.
  static FrameBox around(const Triangle& t) {
    FrameBox out;
    for (int i = 0; i < 3; ++i) {
      out.lo[i] = std::min({t.a[i], t.b[i], t.c[i]}) - kBoxPadding;
      out.hi[i] = std::max({t.a[i], t.b[i], t.c[i]}) + kBoxPadding;
    }
    return out;
  }

  // Of a box in double, padded by kBoxPadding and rounded outwards.
  static FrameBox around(const Frame& frame, const Box& box) {
    FrameBox out;
    Vec3 lo = frame.to_frame(box.lo), hi = frame.to_frame(box.hi);
    for (int i = 0; i < 3; ++i) {
      out.lo[i] = std::nextafter(static_cast<float>(lo[i]) - kBoxPadding, -2.0f);
      out.hi[i] = std::nextafter(static_cast<float>(hi[i]) + kBoxPadding, 2.0f);
    }
    return out;
  }

  bool empty() const { return !(lo[0] <= hi[0] && lo[1] <= hi[1] && lo[2] <= hi[2]); }
  void extend(const FrameBox& b) {
    for (int i = 0; i < 3; ++i) lo[i] = std::min(lo[i], b.lo[i]), hi[i] = std::max(hi[i], b.hi[i]);
  }
  FrameBox joined(const FrameBox& b) const {
    FrameBox out = *this;
    out.extend(b);
    return out;
  }
  FrameBox intersected(const FrameBox& b) const {
    FrameBox out;
    for (int i = 0; i < 3; ++i) out.lo[i] = std::max(lo[i], b.lo[i]), out.hi[i] = std::min(hi[i], b.hi[i]);
    return out;
  }
  FrameBox padded(float by) const {
    FrameBox out = *this;
    for (int i = 0; i < 3; ++i) out.lo[i] -= by, out.hi[i] += by;
    return out;
  }
  float extent(int axis) const { return hi[axis] - lo[axis]; }
  float centre(int axis) const { return 0.5f * lo[axis] + 0.5f * hi[axis]; }
  int longest_axis() const {
    return extent(0) >= extent(1) ? (extent(0) >= extent(2) ? 0 : 2) : (extent(1) >= extent(2) ? 1 : 2);
  }
  // Half the surface: in proportion to the chance that a line meets the box. Empty: 0.
  float half_area() const {
    float x = extent(0), y = extent(1), z = extent(2);
    return x < 0.0f ? 0.0f : x * y + y * z + z * x;
  }
};

inline constexpr uint32_t kTriangleBlock = 8;  // triangles that are tested together

struct PrimitiveSet {
  std::span<const FrameBox> boxes;  // padded by kBoxPadding
  float test_cost = 1.0f;           // of a primitive, in steps from a node to its child
  const Mesh* mesh = nullptr;       // whose faces they are; otherwise a primitive fills its box

  size_t size() const { return boxes.size(); }
  uint32_t tested_together() const { return mesh ? kTriangleBlock : 1; }
  FrameBox bounds() const {
    FrameBox out;
    for (const FrameBox& box : boxes) out.extend(box);
    return out;
  }
  // Shrinks `part`, a region on entry, to the box (of a triangle not padded) of what of the primitive lies in it; false
  // where nothing does.
  bool clip_to(uint32_t primitive, FrameBox& part) const {
    part = part.intersected(boxes[primitive]);
    return !part.empty() && (!mesh || clip_triangle(mesh->triangle(primitive), part.lo, part.hi));
  }
};

}  // namespace tilecast
