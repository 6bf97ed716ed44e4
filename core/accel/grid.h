// A uniform grid, walked cell by cell; or two levels of them, where crowded cells hold grids of their own.
//
// Amanatides and Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing", Eurographics 1987. Cells are counted in
// integers and planes are computed from their number, never summed up, so that nothing drifts and a corner cannot stall
// the walk: it takes at most nx + ny + nz steps. A primitive stands in every cell that its padded box (or its clipped
// part) meets. A hit outside the cell counts: it is a hit of the ray, and lowers s_max.
#pragma once

#include <vector>

#include "accel/traversal.h"

namespace tilecast {

class Grid {
 public:
  static constexpr uint32_t kSubgrid = ~0u;  // as a cell's count: `first` is a level
  struct Cell {
    uint32_t first, count;  // references
  };
  struct Level {
    float lo[3], size[3], reciprocal[3];  // of the grid's lower corner; of a cell
    int cells[3];
    uint32_t first_cell;

    float plane(int axis, int k) const { return std::fma(static_cast<float>(k), size[axis], lo[axis]); }
    FrameBox cell_box(uint32_t cell) const {
      const int at[3] = {static_cast<int>(cell) % cells[0], static_cast<int>(cell) / cells[0] % cells[1],
                         static_cast<int>(cell) / cells[0] / cells[1]};
      FrameBox out;
      for (int i = 0; i < 3; ++i) out.lo[i] = plane(i, at[i]), out.hi[i] = plane(i, at[i] + 1);
      return out;
    }
    // The last cell whose lower plane is not above x.
    int cell_of(int axis, float x) const {
      float guess = (x - lo[axis]) * reciprocal[axis];
      int k = guess >= 0.0f ? static_cast<int>(std::min(guess, static_cast<float>(cells[axis] - 1))) : 0;
      while (k + 1 < cells[axis] && plane(axis, k + 1) <= x) ++k;
      while (k > 0 && plane(axis, k) > x) --k;
      return k;
    }
  };

  // The resolution is the one with the least expected cost; `order` receives the references of the cells.
  static Grid build(const PrimitiveSet& primitives, bool two_levels, std::vector<uint32_t>& order);

  const std::vector<Level>& levels() const { return levels_; }
  size_t node_count() const { return cells_.size(); }
  uint64_t bytes() const { return levels_.size() * sizeof(Level) + cells_.size() * sizeof(Cell); }
  double expected_cost(float test_cost) const;

  // Calls leaf(first, count) for the cells that the ray passes in [s_min, s_max], in order; see Bvh::traverse.
  template <class Cost, class Leaf>
  bool traverse(const FrameRay& ray, float s_min, const float& s_max, Cost& cost, Leaf&& leaf) const {
    return walk<true>(levels_[0], ray, s_min, s_max, cost, leaf);
  }

 private:
  template <bool kTop, class Cost, class Leaf>
  bool walk(const Level& level, const FrameRay& ray, float s_min, const float& s_max, Cost& cost, Leaf&& leaf) const {
    float hi[3];
    for (int i = 0; i < 3; ++i) hi[i] = level.plane(i, level.cells[i]);
    float s = enter(level.lo, hi, ray, s_min, s_max);
    if (s == kMissed) return false;

    int at[3], step[3];
    float next[3];  // where the ray leaves the cell, along each axis
    for (int i = 0; i < 3; ++i) {
      bool forward = !std::signbit(ray.reciprocal[i]);
      step[i] = forward ? 1 : -1;
      // The cell at s by the planes' own parameters: none before it is left later than s, none after it begun earlier.
      int k = level.cell_of(i, std::fma(s, ray.direction[i], ray.origin[i]));
      auto leave = [&](int cell) { return crossing(ray, i, level.plane(i, forward ? cell + 1 : cell)); };
      while (leave(k) < s && (forward ? k + 1 < level.cells[i] : k > 0)) k += step[i];
      while ((forward ? k > 0 : k + 1 < level.cells[i]) && leave(k - step[i]) >= s) k -= step[i];
      at[i] = k;
      next[i] = leave(k);
    }
    for (;;) {
      cost.step();
      const Cell& cell = cells_[level.first_cell + at[0] + level.cells[0] * (at[1] + level.cells[1] * at[2])];
      if (kTop && cell.count == kSubgrid) {
        if (walk<false>(levels_[cell.first], ray, s_min, s_max, cost, leaf)) return true;
      } else if (cell.count > 0 && leaf(cell.first, cell.count)) {
        return true;
      }
      int axis = next[0] <= next[1] ? (next[0] <= next[2] ? 0 : 2) : (next[1] <= next[2] ? 1 : 2);
      if (next[axis] > s_max) return false;
      at[axis] += step[axis];
      if (at[axis] < 0 || at[axis] >= level.cells[axis]) return false;
      next[axis] = crossing(ray, axis, level.plane(axis, at[axis] + (step[axis] > 0 ? 1 : 0)));
    }
  }

  std::vector<Level> levels_;  // [0]: the whole; then those of crowded cells
  std::vector<Cell> cells_;
};

}  // namespace tilecast
