// What decides most rays through a CSG of solids, in single precision and eight operands at a time.
//
// A filter in the sense of exact geometric computation (Fortune and Van Wyk, "Efficient Exact Arithmetic for
// Computational Geometry", SoCG 1993): interval bounds say where each operand's crossings can be; where these overlap
// nothing, the order of the crossings is known, and with it which one is the result's first. That one alone is then
// solved as scene/csg.cpp does, to the same bits. Operands whose bounds do not suffice are solved at once; where two
// exact crossings are still one event, the answer is `Unsure`, and the walk of scene/csg.h decides.
//
// In the frame of the operands a line in float lies within kDisplacement of the exact one, all rounding of the solver
// included: a point of it is inside for sure where it is inside the operand shrunk by that, and outside for sure where
// it is outside of the operand grown by that.
#pragma once

#include <bit>
#include <vector>

#include "scene/float_line.h"

namespace tilecast {

struct Csg;
struct Scene;

struct CsgFilter {
  static constexpr size_t kMostLevels = 8;  // of boxes
  // Each operand is where all of its parts are: a ball of radius 1 after a linear map (a sphere; a cylinder's side, by
  // a map that leaves out the axis), and up to three slabs. Parts that an operand does not have are everywhere.
  struct Slab {
    Float8 normal[3];
    Float8 low[2], high[2];  // grown, shrunk
  };
  struct Batch {
    Float8 map[3][3], centre[3];  // rows
    Float8 radius2[2];            // grown, shrunk
    Slab slabs[3];
    int slab_count;
    bool balls;   // there are any
    bool even;    // the maps scale alone, in all directions alike; the radii are then those in the frame
    Mask8 rough;  // operands of which this is but a bound: never inside for sure
    uint32_t operand[kLanes];
    int count;
  };
  // The same of one operand, for rays that are looked at together (scene/csg_lanes.h).
  struct Single {
    struct Slab {
      float normal[3], low[2], high[2];
      int along;  // its normal is this axis of the frame, for which the line has a reciprocal; else -1
    };
    // Even: in all of the frame's axes or in two of them alike; the radii are then those in the frame.
    enum class Ball : uint8_t { None, Even, Mapped } ball;
    float map[3][3], centre[3], radius2[2];
    int rows;     // even: how many axes; else of the map, that are not zero
    int axes[3];  // even: which
    Slab slabs[3];
    int slab_count;
    bool rough;
    uint32_t operand;
    bool solved_in_lanes;
  };
  std::vector<Batch> batches;
  std::vector<Single> singles;  // the operands of a single batch
  std::vector<BoxLanes> boxes;   // of the batches, eight at a time; then of each of these, and so on up to a single one
  std::vector<uint32_t> levels;  // where in `boxes` each begins
  float stride = kNowhere;       // frame units: on so much of a line it is expected to meet three batches
  FrameBox result_box;
  // Of a single batch: whether a point is inside the result, by the lanes that it is inside of.
  bool inside[1 << kLanes] = {};
  Mask8 inside_bits = {};  // the same, a bit each

  bool usable() const { return !batches.empty(); }

  // Calls visit(batch) for all whose boxes meet the line in s_min .. s_max; false as soon as that is.
  template <class Visit>
  bool each_met(const FloatLine& line, float s_min, float s_max, Visit&& visit) const {
    struct Entry {
      size_t group;  // in its level
      uint32_t met;
    } open[kMostLevels];
    Float8 from;
    size_t level = levels.size() - 1;
    open[level] = {0, bits(meets(boxes.back(), line, s_min, s_max, from))};
    while (level < levels.size()) {
      Entry& entry = open[level];
      if (entry.met == 0) {
        ++level;
        continue;
      }
      const size_t below = entry.group * kLanes + std::countr_zero(entry.met);
      entry.met &= entry.met - 1;
      if (level == 0) {
        if (!visit(batches[below])) return false;
      } else {
        --level;
        open[level] = {below, bits(meets(boxes[levels[level] + below], line, s_min, s_max, from))};
      }
    }
    return true;
  }
};

// Empty where the CSG is not such, or has too many operands.
CsgFilter make_filter(const Csg& csg, const Scene& scene);

}  // namespace tilecast
