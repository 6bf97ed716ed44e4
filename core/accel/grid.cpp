#include "accel/grid.h"

#include "accel/reference.h"

namespace tilecast {
namespace {

constexpr double kMostCells = 1 << 26;
constexpr double kMostReferences = 16.0;  // for each primitive, and a few hundred more
constexpr double kMostCellsEach = 8.0;    // likewise
constexpr uint32_t kCrowded = 8;          // cells with more references may get a grid of their own
constexpr size_t kSample = 4096;          // items that the choice of a resolution looks at

Grid::Level level_over(const FrameBox& bounds, const int cells[3]) {
  Grid::Level level;
  for (int i = 0; i < 3; ++i) {
    level.cells[i] = cells[i];
    level.lo[i] = bounds.lo[i];
    level.size[i] = bounds.extent(i) / static_cast<float>(cells[i]);
    // Rounding must not leave the upper end outside.
    while (level.plane(i, cells[i]) < bounds.hi[i]) level.size[i] = std::nextafter(level.size[i], 4.0f);
    level.reciprocal[i] = 1.0f / level.size[i];
  }
  return level;
}

double surface(double x, double y, double z) { return x * y + y * z + z * x; }

// Visits the cells that an item's box meets; visit(index of the cell in the level) for each.
template <class Visit>
void for_cells(const Grid::Level& level, const Reference& item, const PrimitiveSet& primitives, Visit&& visit) {
  int lo[3], hi[3], spread = 0;
  for (int i = 0; i < 3; ++i) {
    lo[i] = level.cell_of(i, item.box.lo[i]), hi[i] = level.cell_of(i, item.box.hi[i]);
    spread += hi[i] > lo[i];
  }
  for (int z = lo[2]; z <= hi[2]; ++z)
    for (int y = lo[1]; y <= hi[1]; ++y)
      for (int x = lo[0]; x <= hi[0]; ++x) {
        const uint32_t cell = static_cast<uint32_t>(x + level.cells[0] * (y + level.cells[1] * z));
        FrameBox part = level.cell_box(cell).padded(kBoxPadding);
        // Across one axis a box is full enough.
        if (spread <= 1 || primitives.clip_to(item.primitive, part)) visit(cell);
      }
}

// The cheapest number of cells: a line through the grid enters a cell with the chance of their surfaces' ratio, and
// tests what stands there. Looks at every so manyth item.
void choose_cells(const References& items, const FrameBox& bounds, float test_cost, int cells[3]) {
  const size_t stride = items.size() / kSample + 1;
  const double n = static_cast<double>(items.size());
  const double whole = surface(bounds.extent(0), bounds.extent(1), bounds.extent(2));
  double best = std::numeric_limits<double>::infinity();
  cells[0] = cells[1] = cells[2] = 1;
  for (double edge = bounds.extent(bounds.longest_axis());; edge *= 0.75) {
    int candidate[3];
    for (int i = 0; i < 3; ++i) candidate[i] = std::max(1, static_cast<int>(std::rint(bounds.extent(i) / edge)));
    const double count = double(candidate[0]) * candidate[1] * candidate[2];
    if (count > std::min(kMostCells, kMostCellsEach * n + 64)) return;
    Grid::Level level = level_over(bounds, candidate);
    double references = 0.0;
    for (size_t k = 0; k < items.size(); k += stride) {
      double here = 1.0;
      for (int i = 0; i < 3; ++i)
        here *= 1.0 + level.cell_of(i, items[k].box.hi[i]) - level.cell_of(i, items[k].box.lo[i]);
      references += here * stride;
    }
    if (references > kMostReferences * n + 256) return;
    const double chance = surface(level.size[0], level.size[1], level.size[2]) / whole;
    const double cost = chance * (count + test_cost * references);
    if (cost < best) best = cost, std::copy_n(candidate, 3, cells);
  }
}

}  // namespace

Grid Grid::build(const PrimitiveSet& primitives, bool two_levels, std::vector<uint32_t>& order) {
  Grid grid;
  order.clear();
  struct Task {
    FrameBox bounds;
    References items;
    int cells[3];
    uint32_t cell;  // that becomes a level; kWhole at the top
  };
  constexpr uint32_t kWhole = ~0u;
  std::vector<Task> tasks(1);
  tasks[0].bounds = primitives.bounds();
  tasks[0].cell = kWhole;
  tasks[0].items = references_to(primitives);
  choose_cells(tasks[0].items, tasks[0].bounds, primitives.test_cost, tasks[0].cells);
  while (!tasks.empty()) {
    Task task = std::move(tasks.back());
    tasks.pop_back();
    const int* counts = task.cells;
    Level level = level_over(task.bounds, counts);
    level.first_cell = static_cast<uint32_t>(grid.cells_.size());
    if (task.cell != kWhole) grid.cells_[task.cell] = {static_cast<uint32_t>(grid.levels_.size()), kSubgrid};
    grid.levels_.push_back(level);
    const size_t size = size_t(counts[0]) * counts[1] * counts[2];
    grid.cells_.resize(level.first_cell + size);

    // The items of each cell, in the order of the primitives: counted, then filled in.
    std::vector<std::pair<uint32_t, uint32_t>> entries;  // cell, item
    for (uint32_t i = 0; i < task.items.size(); ++i)
      for_cells(level, task.items[i], primitives, [&](uint32_t cell) { entries.push_back({cell, i}); });
    std::vector<uint32_t> first(size + 1);
    for (const auto& entry : entries) ++first[entry.first + 1];
    for (size_t c = 0; c < size; ++c) first[c + 1] += first[c];
    std::vector<uint32_t> sorted(entries.size()), fill(first.begin(), first.end() - 1);
    for (const auto& [cell, item] : entries) sorted[fill[cell]++] = item;
    entries = {};

    for (uint32_t c = 0; c < size; ++c) {
      const std::span<const uint32_t> here(sorted.data() + first[c], first[c + 1] - first[c]);
      if (two_levels && task.cell == kWhole && here.size() > kCrowded) {
        Task crowded;
        crowded.cell = level.first_cell + c;
        crowded.bounds = level.cell_box(c);
        for (uint32_t item : here) {
          FrameBox part = crowded.bounds.padded(kBoxPadding);
          if (primitives.clip_to(task.items[item].primitive, part))
            crowded.items.push_back({part.padded(kBoxPadding), task.items[item].primitive});
        }
        choose_cells(crowded.items, crowded.bounds, primitives.test_cost, crowded.cells);
        if (crowded.cells[0] * crowded.cells[1] * crowded.cells[2] > 1) {
          tasks.push_back(std::move(crowded));
          continue;
        }
      }
      grid.cells_[level.first_cell + c] = {static_cast<uint32_t>(order.size()), static_cast<uint32_t>(here.size())};
      for (uint32_t item : here) order.push_back(task.items[item].primitive);
    }
  }
  grid.cells_.shrink_to_fit();
  order.shrink_to_fit();
  return grid;
}

double Grid::expected_cost(float test_cost) const {
  auto whole = [](const Level& l) {
    return surface(double(l.size[0]) * l.cells[0], double(l.size[1]) * l.cells[1], double(l.size[2]) * l.cells[2]);
  };
  double sum = 0.0;
  for (const Level& level : levels_) {
    double chance = surface(level.size[0], level.size[1], level.size[2]) / whole(levels_[0]);
    size_t size = size_t(level.cells[0]) * level.cells[1] * level.cells[2];
    for (size_t c = level.first_cell; c < level.first_cell + size; ++c)
      sum += chance * (1.0 + (cells_[c].count == kSubgrid ? 0.0 : test_cost * cells_[c].count));
  }
  return sum;
}

}  // namespace tilecast
