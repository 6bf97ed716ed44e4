#include "scene/csg_filter.h"

#include "scene/csg.h"
#include "geometry/sure_lanes.h"
#include "scene/csg_ends.h"

namespace tilecast {
namespace {

constexpr size_t kMostFilterOperands = 1 << 17;  // 20 MB
constexpr double kMostStretch = 0x1p80;  // of a ball's map, squared: its own square, and that of its inverse, are floats
constexpr double kExpected = 3, kShortestStride = 0x1p-6;  // batches on a stride, and its length in frame units

using Batch = CsgFilter::Batch;

void set_slab(Batch& batch, int lane, int number, const Vec3& row, const Vec3& centre, double low, double high) {
  // low < row (p - centre) < high
  CsgFilter::Slab& slab = batch.slabs[number];
  double length = std::sqrt(glm::dot(row, row));
  Vec3 normal = row / length;
  double at = glm::dot(normal, centre);
  for (int i = 0; i < 3; ++i) slab.normal[i][lane] = static_cast<float>(normal[i]);
  auto put = [&](Float8 (&ends)[2], double end, double outwards) {
    for (int k = 0; k < 2; ++k) {
      double x = end / length + at + (k == 0 ? outwards : -outwards);
      ends[k][lane] = static_cast<float>(std::clamp(x, -1.0 * kNowhere, 1.0 * kNowhere));
    }
  };
  put(slab.low, low, -kDisplacement);
  put(slab.high, high, kDisplacement);
  if (!(slab.low[1][lane] < slab.high[1][lane])) batch.rough[lane] = -1;
  batch.slab_count = std::max(batch.slab_count, number + 1);
}

// False where the squares of the map could leave the range of floats.
bool set_ball(Batch& batch, int lane, const Vec3 rows[3], const Vec3& centre) {
  batch.balls = true;
  double stretch = 0.0;
  for (int i = 0; i < 3; ++i) {
    stretch += glm::dot(rows[i], rows[i]);
    batch.centre[i][lane] = static_cast<float>(centre[i]);
    for (int j = 0; j < 3; ++j) batch.map[i][j][lane] = static_cast<float>(rows[i][j]);
  }
  if (!(stretch >= 1.0 / kMostStretch && stretch <= kMostStretch)) return false;
  double displacement = kDisplacement * std::sqrt(stretch) + kRelative;
  for (int k = 0; k < 2; ++k) {
    double radius = 1.0 + (k == 0 ? displacement : -displacement);
    batch.radius2[k][lane] = static_cast<float>(radius > 0.0 ? radius * radius : 0.0);
  }
  if (displacement > 0.25) batch.rough[lane] = -1;
  return true;
}

// False where the bounds of the exact crossings could be larger than the filter has room for, or its floats are too small.
bool set_operand(Batch& batch, int lane, const Csg& csg, uint32_t index, const Scene& scene) {
  const Frame& frame = csg.assembly.frame;
  const Instance& instance = csg.assembly.instances[index];
  if (!(instance.to_local.stretch() * instance.to_parent.stretch() <= kCondition)) return false;
  Vec3 centre = frame.to_frame(instance.to_parent.offset);
  if (!(max_abs(centre) <= kFarthest && max_abs(frame.centre) <= kFarthest * frame.scale)) return false;
  Vec3 rows[3];  // of the map from the frame to the operand's space
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) rows[i][j] = instance.to_local.linear[j][i] * frame.scale;
  batch.operand[lane] = index;
  for (Float8& radius2 : batch.radius2) radius2[lane] = 1.0f;
  const Solid& solid = scene.solids[scene.objects[instance.object].index];
  auto slab = [&](int number, const Vec3& row, double low, double high) {
    set_slab(batch, lane, number, row, centre, low, high);
  };
  if (auto* sphere = std::get_if<Sphere>(&solid)) {
    for (Vec3& row : rows) row /= sphere->radius;
    return set_ball(batch, lane, rows, centre);
  } else if (auto* cylinder = std::get_if<Cylinder>(&solid)) {
    slab(0, rows[1], -0.5 * cylinder->height, 0.5 * cylinder->height);
    Vec3 side[3]{rows[0] / cylinder->radius, rows[2] / cylinder->radius, Vec3(0.0)};
    return set_ball(batch, lane, side, centre);
  } else if (auto* halfspace = std::get_if<Halfspace>(&solid)) {  // its cut lies outside of the result
    Vec3 row = halfspace->normal.x * rows[0] + halfspace->normal.y * rows[1] + halfspace->normal.z * rows[2];
    slab(0, row, -kInfinity, halfspace->offset);
  } else {
    Box box = bounds(solid);
    for (int i = 0; i < 3; ++i) slab(i, rows[i], box.lo[i], box.hi[i]);
    if (!std::holds_alternative<Block>(solid)) batch.rough[lane] = -1;
  }
  return true;
}

Batch empty_batch() {
  Batch batch{};
  batch.radius2[0] = batch.radius2[1] = all(-1.0f);  // nowhere
  for (CsgFilter::Slab& slab : batch.slabs)
    for (int k = 0; k < 2; ++k) slab.low[k] = all(-kNowhere), slab.high[k] = all(kNowhere);
  return batch;
}

constexpr float kNothing = 0x1p-30f;  // of a direction's length: far below what kDisplacement has room for

// The axis of the frame along which a row points, or -1; `size`: how far, with its sign.
int axis_of(const float (&row)[3], float& size) {
  int axis = 0;
  for (int i = 1; i < 3; ++i)
    if (std::fabs(row[i]) > std::fabs(row[axis])) axis = i;
  size = row[axis];
  for (int i = 0; i < 3; ++i)
    if (i != axis && !(std::fabs(row[i]) <= kNothing * std::fabs(size))) return -1;
  return size != 0.0f ? axis : -1;
}

// One operand of a batch.
CsgFilter::Single single(const Batch& batch, int lane, const Solid& solid) {
  using Single = CsgFilter::Single;
  Single out{};
  out.operand = batch.operand[lane];
  out.rough = batch.rough[lane] != 0;
  out.solved_in_lanes = has_sure_lanes(solid);
  out.ball = Single::Ball::None;
  for (int i = 0; i < 3; ++i) {
    out.centre[i] = batch.centre[i][lane];
    for (int j = 0; j < 3; ++j) {
      out.map[i][j] = batch.map[i][j][lane];
      if (out.map[i][j] != 0.0f) out.ball = Single::Ball::Mapped, out.rows = i + 1;
    }
  }
  float sizes[3];
  bool even = out.ball == Single::Ball::Mapped;
  for (int i = 0; even && i < out.rows; ++i) {
    out.axes[i] = axis_of(out.map[i], sizes[i]);
    even = out.axes[i] >= 0 && std::fabs(std::fabs(sizes[i]) - std::fabs(sizes[0])) <= kNothing * std::fabs(sizes[0]);
  }
  if (even) out.ball = Single::Ball::Even;
  for (int k = 0; k < 2; ++k) {
    out.radius2[k] = batch.radius2[k][lane];
    if (even && !batch.even) out.radius2[k] /= sizes[0] * sizes[0];
  }
  for (int number = 0; number < batch.slab_count; ++number) {
    const CsgFilter::Slab& slab = batch.slabs[number];
    Single::Slab& to = out.slabs[out.slab_count];
    float size;
    for (int i = 0; i < 3; ++i) to.normal[i] = slab.normal[i][lane];
    to.along = axis_of(to.normal, size);
    for (int k = 0; k < 2; ++k) {
      to.low[k] = slab.low[k][lane], to.high[k] = slab.high[k][lane];
      if (to.along < 0) continue;
      to.low[k] /= size, to.high[k] /= size;
      if (size < 0.0f) std::swap(to.low[k], to.high[k]);
    }
    if (slab.low[0][lane] > -kNowhere || slab.high[0][lane] < kNowhere) ++out.slab_count;
  }
  return out;
}

// The hierarchy of the batches' boxes, which are in the order of places; and how they crowd the result.
void put_boxes(std::vector<FrameBox> box, const FrameBox& result, CsgFilter& out) {
  // By Crofton's formula a line through a convex body meets a body within it as often as their surfaces are one to the
  // other; and 4 V / S is the mean length of such a line (Santalo, "Integral Geometry and Geometric Probability", 1976).
  double area = 0.0, volume = 1.0;
  for (const FrameBox& one : box) {
    const FrameBox within = one.intersected(result);
    if (!within.empty()) area += within.half_area();
  }
  for (int i = 0; i < 3; ++i) volume *= double(result.hi[i]) - result.lo[i];
  if (area > 0.0)
    out.stride = static_cast<float>(std::clamp(kExpected * 2.0 * volume / area, kShortestStride, double(kNowhere)));
  do {
    out.levels.push_back(static_cast<uint32_t>(out.boxes.size()));
    std::vector<FrameBox> above;
    for (size_t i = 0; i < box.size(); ++i) {
      if (i % kLanes == 0) above.emplace_back(), out.boxes.emplace_back();
      above.back().extend(box[i]);
      out.boxes.back().set(i % kLanes, box[i]);
    }
    box = std::move(above);
  } while (box.size() > 1);
}

}  // namespace

CsgFilter make_filter(const Csg& csg, const Scene& scene) {
  CsgFilter out;
  const Assembly& assembly = csg.assembly;
  if (assembly.instances.size() > kMostFilterOperands || csg.nodes.size() > kMostFilterNodes) return out;
  for (const Instance& instance : assembly.instances)
    if (scene.objects[instance.object].kind != Kind::Solid) return out;
  // In the order of the hierarchy's leaves, which is that of places; large operands apart from small ones.
  std::vector<uint32_t> order = assembly.accelerator.order();
  std::vector<FrameBox> box;
  for (const Instance& instance : assembly.instances)
    box.push_back(FrameBox::around(assembly.frame, instance.to_parent.box(scene.objects[instance.object].bounds)));
  std::stable_partition(order.begin(), order.end(),
                        [&](uint32_t i) { return box[i].half_area() > 0.25f * csg.result_box.half_area(); });
  std::vector<FrameBox> batch_box;
  for (size_t first = 0; first < order.size(); first += kLanes) {
    Batch batch = empty_batch();
    FrameBox around;
    batch.count = static_cast<int>(std::min<size_t>(kLanes, order.size() - first));
    for (int lane = 0; lane < batch.count; ++lane) {
      if (!set_operand(batch, lane, csg, order[first + lane], scene)) return {};
      around.extend(box[order[first + lane]]);
    }
    batch.even = true;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (int lane = 0; lane < batch.count; ++lane)
          batch.even &= batch.map[i][j][lane] == (i == j ? batch.map[0][0][lane] : 0.0f);
    if (batch.even && batch.balls)
      for (int lane = 0; lane < batch.count; ++lane)
        for (Float8& radius2 : batch.radius2) radius2[lane] /= batch.map[0][0][lane] * batch.map[0][0][lane];
    batch_box.push_back(around.padded(static_cast<float>(kRoom)));
    out.batches.push_back(batch);
  }
  if (order.size() > 2 * kLanes) put_boxes(std::move(batch_box), csg.result_box, out);
  if (out.batches.size() == 1)
    for (uint32_t within = 0; within < 1u << order.size(); ++within) {
      uint32_t inside[kMostFilterNodes] = {};
      uint8_t first_inside[kMostFilterNodes] = {};
      CsgState state{inside, first_inside};
      for (size_t lane = 0; lane < order.size(); ++lane)
        if (within >> lane & 1) state.enter(csg, order[lane], true);
      out.inside[within] = state.at(csg.nodes[0], 0);
      if (out.inside[within]) out.inside_bits[within >> 5] |= static_cast<int32_t>(1u << (within & 31));
    }
  if (out.batches.size() == 1)
    for (int lane = 0; lane < out.batches[0].count; ++lane)
      out.singles.push_back(single(out.batches[0], lane, scene.solids[scene.objects[assembly.instances[out.batches[0].operand[lane]].object].index]));
  out.result_box = csg.result_box.padded(static_cast<float>(kRoom));
  return out;
}

}  // namespace tilecast
