#include "scene/csg_filter.h"

#include "base/counters.h"
#include "scene/csg.h"

namespace tilecast {
namespace {

// Displacements in units of the frame, in which the operands lie within [-1, 1]^3 and the part of the line that can
// meet them within |s| < 2, |direction| in [1, 2 sqrt 3). With e = 2^-24: origin 2e, direction 2e s, the maps'
// coefficients and their application to both 24e (rows of length 1), the solver's root 4e: below 2^-18 with the bounds
// of the exact crossings, which are 2^-24 at most (kFarthest, kCondition); twice that, and twice again.
constexpr double kDisplacement = 0x1p-16;
constexpr double kRelative = 0x1p-19;  // of a ball's radius, for the solver
constexpr double kFarthest = 0x1p16;   // of a line's origin, frame units
constexpr double kCondition = 0x1p8;   // of an operand's transform
constexpr float kNowhere = 1e30f;
constexpr double kRoom = 0x1p-12;      // frame units: what is nearer to an end of the range is not left out

constexpr size_t kMostOperands = 512, kMostNodes = 32;
constexpr int kMostEvents = 64;

// --- Building

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

void set_ball(Batch& batch, int lane, const Vec3 rows[3], const Vec3& centre) {
  double stretch = 0.0;
  for (int i = 0; i < 3; ++i) {
    stretch += glm::dot(rows[i], rows[i]);
    batch.centre[i][lane] = static_cast<float>(centre[i]);
    for (int j = 0; j < 3; ++j) batch.map[i][j][lane] = static_cast<float>(rows[i][j]);
  }
  double displacement = kDisplacement * std::sqrt(stretch) + kRelative;
  for (int k = 0; k < 2; ++k) {
    double radius = 1.0 + (k == 0 ? displacement : -displacement);
    batch.radius2[k][lane] = static_cast<float>(radius > 0.0 ? radius * radius : 0.0);
  }
  if (displacement > 0.25) batch.rough[lane] = -1;
}

// False where the bounds of the exact crossings could be larger than the filter has room for.
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
  const Solid& solid = scene.solids[scene.objects[instance.object].index];
  auto slab = [&](int number, const Vec3& row, double low, double high) {
    set_slab(batch, lane, number, row, centre, low, high);
  };
  if (auto* sphere = std::get_if<Sphere>(&solid)) {
    for (Vec3& row : rows) row /= sphere->radius;
    set_ball(batch, lane, rows, centre);
  } else if (auto* cylinder = std::get_if<Cylinder>(&solid)) {
    slab(0, rows[1], -0.5 * cylinder->height, 0.5 * cylinder->height);
    Vec3 side[3]{rows[0] / cylinder->radius, rows[2] / cylinder->radius, Vec3(0.0)};
    set_ball(batch, lane, side, centre);
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
  batch.radius2[0] = batch.radius2[1] = all(1.0f);
  for (CsgFilter::Slab& slab : batch.slabs)
    for (int k = 0; k < 2; ++k) slab.low[k] = all(-kNowhere), slab.high[k] = all(kNowhere);
  return batch;
}

// --- Asking

// The line in the frame: t of the ray = (start + s) * scale.
struct FilterLine {
  float origin[3], direction[3];
  double start, scale;

  double t(float s) const { return (start + s) * scale; }
};

// False where the line passes the operands by.
bool enter(const Frame& frame, const Ray& ray, FilterLine& out, bool& far) {
  Vec3 origin = frame.to_frame(ray.origin);
  double largest = max_abs(ray.direction);
  if (!(largest >= 0x1p-1000 && largest <= 0x1p1000)) return false;
  double normalise = power_below_reciprocal(largest);
  Vec3 direction = ray.direction * normalise;
  out.scale = frame.scale * normalise;
  out.start = -glm::dot(origin, direction) / glm::dot(direction, direction);
  Vec3 nearest = origin + out.start * direction;
  if (!(glm::dot(nearest, nearest) <= 4.0)) return false;
  far = !(max_abs(origin) <= kFarthest);
  for (int i = 0; i < 3; ++i) {
    out.origin[i] = static_cast<float>(nearest[i]);
    out.direction[i] = static_cast<float>(direction[i]);
  }
  return true;
}

// Where a batch's operands can begin and end: bounds on each.
struct Ends {
  Float8 in[2], out[2];
};

inline Ends ends_of(const Batch& batch, const FilterLine& line) {
  Float8 o[3], d[3];
  Float8 a = all(0.0f), b = all(0.0f);
  {
    Float8 from[3];
    for (int i = 0; i < 3; ++i) from[i] = line.origin[i] - batch.centre[i];
    for (int i = 0; i < 3; ++i) {
      const auto& row = batch.map[i];
      o[i] = fma(row[0], from[0], fma(row[1], from[1], row[2] * from[2]));
      d[i] = fma(row[0], all(line.direction[0]), fma(row[1], all(line.direction[1]), row[2] * line.direction[2]));
    }
  }
  for (int i = 0; i < 3; ++i) a = fma(d[i], d[i], a);
  Mask8 along = a < 1e-20f;  // the axis, to within rounding
  for (int i = 0; i < 3; ++i) {
    d[i] = along ? all(0.0f) : d[i];
    b = fma(o[i], d[i], b);
  }
  Float8 inverse = 1.0f / max(a, all(1e-20f));
  Float8 middle = -b * inverse, distance2 = all(0.0f);
  for (int i = 0; i < 3; ++i) {
    Float8 nearest = fma(middle, d[i], o[i]);
    distance2 = fma(nearest, nearest, distance2);
  }
  Float8 wide = batch.radius2[0] - distance2, narrow = batch.radius2[1] - distance2;
  Float8 wide_half = sqrt(max(wide, all(0.0f)) * inverse), narrow_half = sqrt(max(narrow, all(0.0f)) * inverse);
  Ends ends;
  const Float8 none = all(kNowhere);
  Mask8 outside = wide < 0.0f, grazing = (narrow <= 0.0f) | batch.rough;
  ends.in[0] = outside ? none : middle - wide_half;
  ends.out[0] = outside ? -none : middle + wide_half;
  ends.in[1] = grazing ? none : middle - narrow_half;
  ends.out[1] = grazing ? -none : middle + narrow_half;
  for (int i = 0; i < batch.slab_count; ++i) {
    const CsgFilter::Slab& slab = batch.slabs[i];
    const auto& n = slab.normal;
    Float8 at = fma(n[0], all(line.origin[0]), fma(n[1], all(line.origin[1]), n[2] * line.origin[2]));
    Float8 along_n = fma(n[0], all(line.direction[0]), fma(n[1], all(line.direction[1]), n[2] * line.direction[2]));
    Mask8 level = (along_n < 1e-20f) & (along_n > -1e-20f);
    Float8 per = 1.0f / (level ? all(1e-20f) : along_n);
    for (int k = 0; k < 2; ++k) {
      Float8 low = (slab.low[k] - at) * per, high = (slab.high[k] - at) * per;
      ends.in[k] = max(ends.in[k], min(low, high));
      ends.out[k] = min(ends.out[k], max(low, high));
    }
  }
  return ends;
}

inline uint32_t boxes_met(const CsgFilter::Boxes& boxes, const FilterLine& line, const Float8 reciprocal[3], float s_min,
                          float s_max) {
  Float8 from = all(s_min), to = all(s_max);
  for (int i = 0; i < 3; ++i) {
    Float8 a = (boxes.lo[i] - line.origin[i]) * reciprocal[i], b = (boxes.hi[i] - line.origin[i]) * reciprocal[i];
    from = max(from, min(a, b));
    to = min(to, max(a, b));
  }
  return bits(from <= to);
}

struct Event {
  double lo, hi;  // where its t is, with the error bound of the exact one
  double t;       // where it is exact
  uint32_t operand;
  int16_t face;
  uint8_t number;  // among the operand's
  bool entering, exact;
};

class Search {
 public:
  Search(const Scene& scene, const Csg& csg, const Ray& ray, double t_min, double t_max)
      : scene_(scene), csg_(csg), ray_(ray), t_min_(t_min), t_max_(t_max) {
    for (size_t i = 0; i < csg.nodes.size(); ++i) inside_[i] = 0, first_inside_[i] = 0;
  }

  Filtered run(uint64_t base, bool any, Crossing& out);

 private:
  bool gather(const FilterLine& line, float s_min, float s_max);
  bool add(const Event& event);
  int solve(uint32_t operand, SolidCrossing list[kMaxSolidCrossings]) const;
  bool refine(uint32_t operand);
  CsgState state() { return {inside_, first_inside_}; }

  const Scene& scene_;
  const Csg& csg_;
  const Ray& ray_;
  double t_min_, t_max_, low_, high_;
  uint32_t inside_[kMostNodes];
  uint8_t first_inside_[kMostNodes];
  Event events_[kMostEvents];
  int count_ = 0;
};

// False where there is no room for it.
bool Search::add(const Event& event) {
  if (event.lo > high_) return true;
  if (event.hi < low_) {
    state().enter(csg_, event.operand, event.entering);
    return true;
  }
  if (count_ == kMostEvents) return false;
  events_[count_++] = event;
  return true;
}

int Search::solve(uint32_t operand, SolidCrossing list[kMaxSolidCrossings]) const {
  return operand_crossings(scene_, csg_, operand, ray_, list);
}

// Puts the exact crossings of an operand in the place of their bounds; false where they do not fit.
bool Search::refine(uint32_t operand) {
  SolidCrossing list[kMaxSolidCrossings];
  if (solve(operand, list) != 2) return false;
  for (int i = 0; i < count_; ++i) {
    Event& event = events_[i];
    if (event.operand != operand) continue;
    const SolidCrossing& crossing = list[event.number];
    event = {crossing.t - crossing.error, crossing.t + crossing.error, crossing.t, operand,
             static_cast<int16_t>(crossing.face), event.number, crossing.entering, true};
  }
  return true;
}

// The events of all operands; false where there are too many.
bool Search::gather(const FilterLine& line, float s_min, float s_max) {
  const CsgFilter& filter = csg_.filter;
  auto look_at = [&](const Batch& batch) {
    const Ends ends = ends_of(batch, line);
    uint32_t met = bits((ends.in[0] <= ends.out[0]) & (ends.out[0] >= s_min) & (ends.in[0] <= s_max)) &
                   ((1u << batch.count) - 1);
    const uint32_t sure = bits(ends.in[1] < ends.out[1]);
    for (; met != 0; met &= met - 1) {
      const int lane = std::countr_zero(met);
      const uint32_t operand = batch.operand[lane];
      if (sure >> lane & 1) {
        if (!add({line.t(ends.in[0][lane]), line.t(ends.in[1][lane]), 0.0, operand, 0, 0, true, false}) ||
            !add({line.t(ends.out[1][lane]), line.t(ends.out[0][lane]), 0.0, operand, 0, 1, false, false}))
          return false;
        continue;
      }
      SolidCrossing list[kMaxSolidCrossings];
      const int found = solve(operand, list);
      for (int i = 0; i < found; ++i)
        if (!add({list[i].t - list[i].error, list[i].t + list[i].error, list[i].t, operand,
                  static_cast<int16_t>(list[i].face), static_cast<uint8_t>(i), list[i].entering, true}))
          return false;
    }
    return true;
  };
  if (filter.boxes.empty()) {
    for (const Batch& batch : filter.batches)
      if (!look_at(batch)) return false;
    return true;
  }
  Float8 reciprocal[3];
  for (int i = 0; i < 3; ++i) {
    float d = line.direction[i];
    reciprocal[i] = all(1.0f / (std::fabs(d) < 0x1p-40f ? std::copysign(0x1p-40f, d) : d));
  }
  for (size_t group = 0; group < filter.boxes.size(); ++group)
    for (uint32_t met = boxes_met(filter.boxes[group], line, reciprocal, -kNowhere, s_max); met != 0; met &= met - 1)
      if (!look_at(filter.batches[group * kLanes + std::countr_zero(met)])) return false;
  return true;
}

Filtered Search::run(uint64_t base, bool any, Crossing& out) {
  FilterLine line;
  bool far = false;
  if (!enter(csg_.assembly.frame, ray_, line, far)) return Filtered::Nothing;
  if (far) return Filtered::Unsure;
  const FrameBox& box = csg_.filter.result_box;
  float s_min = static_cast<float>(t_min_ / line.scale - line.start - kRoom);
  float s_max = static_cast<float>(t_max_ / line.scale - line.start + kRoom);
  for (int i = 0; i < 3; ++i) {
    float d = line.direction[i];
    float per = 1.0f / (std::fabs(d) < 0x1p-40f ? std::copysign(0x1p-40f, d) : d);
    float a = (box.lo[i] - line.origin[i]) * per, b = (box.hi[i] - line.origin[i]) * per;
    s_min = std::max(s_min, std::min(a, b));
    s_max = std::min(s_max, std::max(a, b));
  }
  if (!(s_min <= s_max)) return Filtered::Nothing;
  low_ = line.t(s_min);
  high_ = line.t(s_max);
  if (!gather(line, s_min, s_max)) return Filtered::Unsure;

  bool inside = state().at(csg_.nodes[0], 0);
  while (count_ > 0) {
    int first = 0;
    for (int i = 1; i < count_; ++i)
      if (events_[i].lo < events_[first].lo) first = i;
    int second = -1;
    for (int i = 0; i < count_; ++i)
      if (i != first && events_[i].lo <= events_[first].hi && (second < 0 || !events_[i].exact)) second = i;
    const Event event = events_[first];
    if (second >= 0) {  // in which order?
      if (!event.exact) {
        if (!refine(event.operand)) return Filtered::Unsure;
      } else if (!events_[second].exact) {
        if (!refine(events_[second].operand)) return Filtered::Unsure;
      } else {
        return Filtered::Unsure;
      }
      continue;
    }
    const bool at_end = event.lo <= t_min_ || event.hi > t_max_ || event.lo < low_ || event.hi > high_;
    if (at_end && !event.exact) {
      if (!refine(event.operand)) return Filtered::Unsure;
      continue;
    }
    state().enter(csg_, event.operand, event.entering);
    const bool now_inside = state().at(csg_.nodes[0], 0);
    events_[first] = events_[--count_];
    if (now_inside == inside) continue;
    inside = now_inside;
    if (at_end) {
      if (event.t > t_max_) return Filtered::Nothing;
      if (!(event.t > t_min_)) continue;
      // What was left out may be together with it.
      if (event.lo < low_ || event.hi > high_) return Filtered::Unsure;
    }
    if (any) return Filtered::Found;
    Event exact = event;
    if (!exact.exact) {
      SolidCrossing list[kMaxSolidCrossings];
      if (solve(event.operand, list) != 2) return Filtered::Unsure;
      exact.t = list[event.number].t;
      exact.face = static_cast<int16_t>(list[event.number].face);
    }
    out = {};
    out.t = exact.t;
    out.primitive = base + csg_.assembly.first_primitive[exact.operand] + exact.face;
    out.entering = now_inside;
    return Filtered::Found;
  }
  return Filtered::Nothing;
}

}  // namespace

CsgFilter make_filter(const Csg& csg, const Scene& scene) {
  CsgFilter out;
  const Assembly& assembly = csg.assembly;
  if (assembly.instances.size() > kMostOperands || csg.nodes.size() > kMostNodes) return out;
  for (const Instance& instance : assembly.instances)
    if (scene.objects[instance.object].kind != Kind::Solid) return out;
  // In the order of the hierarchy's leaves, which is that of places; large operands apart from small ones.
  std::vector<uint32_t> order = assembly.accelerator.order();
  std::vector<FrameBox> box;
  for (const Instance& instance : assembly.instances)
    box.push_back(FrameBox::around(assembly.frame, instance.to_parent.box(scene.objects[instance.object].bounds)));
  std::stable_partition(order.begin(), order.end(),
                        [&](uint32_t i) { return box[i].half_area() > 0.25f * csg.result_box.half_area(); });
  for (size_t first = 0; first < order.size(); first += kLanes) {
    Batch batch = empty_batch();
    FrameBox around;
    batch.count = static_cast<int>(std::min<size_t>(kLanes, order.size() - first));
    for (int lane = 0; lane < batch.count; ++lane) {
      if (!set_operand(batch, lane, csg, order[first + lane], scene)) return {};
      around.extend(box[order[first + lane]]);
    }
    if (order.size() > 2 * kLanes) {
      const size_t number = out.batches.size();
      if (number % kLanes == 0) {
        out.boxes.emplace_back();
        for (int i = 0; i < 3; ++i) out.boxes.back().lo[i] = all(kNowhere), out.boxes.back().hi[i] = all(kNowhere);
      }
      for (int i = 0; i < 3; ++i) {
        out.boxes.back().lo[i][number % kLanes] = around.lo[i] - static_cast<float>(kRoom);
        out.boxes.back().hi[i][number % kLanes] = around.hi[i] + static_cast<float>(kRoom);
      }
    }
    out.batches.push_back(batch);
  }
  out.result_box = csg.result_box.padded(static_cast<float>(kRoom));
  return out;
}

Filtered first_crossing(const Scene& scene, const Csg& csg, const Ray& ray, double t_min, double t_max, uint64_t base,
                        bool any, Crossing& out) {
  TILECAST_COUNT(csg);
  return Search(scene, csg, ray, t_min, t_max).run(base, any, out);
}

}  // namespace tilecast
