#include "scene/packet.h"

#include "base/counters.h"
#include "scene/beam.h"
#include "scene/csg_lanes.h"
#include "scene/descend.h"
#include "scene/trace_object.h"

namespace tilecast {
namespace {

// Eight rays on their way through the scene. kAny: whether each hits anything.
template <bool kAny>
class Packet {
 public:
  Packet(const Scene& scene, const Ray* rays, int count, Hit* best) : scene_(scene), best_(best), open_((1u << count) - 1) {
    for (int lane = 0; lane < kLanes; ++lane) {
      const Ray& ray = rays[lane < count ? lane : 0];
      for (int i = 0; i < 3; ++i) lines_.origin[i].set(lane, ray.origin[i]), lines_.direction[i].set(lane, ray.direction[i]);
      t_min_.set(lane, ray.t_min), t_max_.set(lane, ray.t_max);
      if (!kAny && lane < count) best_[lane] = Hit{ray.t_max};
    }
  }

  void run() {
    const DirectionLanes directions(lines_.direction);
    visit(scene_.objects[scene_.root], {lines_, &directions}, 0, open_);
  }
  bool found(int lane) const { return !(open_ >> lane & 1); }

 private:
  void visit(const Object& object, const RayLanes& rays, uint64_t base, uint32_t lanes) {
    switch (kind_of(object)) {
      case Kind::Group: return visit_group(object, rays, base, lanes);
      case Kind::Csg:
        if (has_lanes(scene_.csgs[object.index])) return visit_csg(object, rays, base, lanes);
        [[fallthrough]];
      default: return one_by_one(object, rays, base, lanes);
    }
  }

  void one_by_one(const Object& object, const RayLanes& rays, uint64_t base, uint32_t lanes) {
    for (; lanes != 0; lanes &= lanes - 1) {
      const int lane = std::countr_zero(lanes);
      const Ray ray = rays.ray(lane, t_min_[lane], t_max_[lane]);
      if constexpr (kAny) {
        if (occluded(scene_, object, ray)) open_ &= ~(1u << lane);
      } else {
        closest(scene_, object, ray, base, best_[lane]);
        t_max_.set(lane, best_[lane].t);
      }
    }
  }

  void offer(int lane, const Hit& hit) {
    if (!hit.before(best_[lane])) return;
    best_[lane] = hit;
    t_max_.set(lane, hit.t);
  }

  void visit_csg(const Object& object, const RayLanes& rays, uint64_t base, uint32_t lanes) {
    const Csg& csg = scene_.csgs[object.index];
    CrossingLanes first;
    first_crossings<kAny>(scene_, csg, rays, lanes, t_min_, t_max_, first);
    if (kAny) {
      open_ &= ~first.found;
    } else {
      for (uint32_t left = first.found; left != 0; left &= left - 1) {
        const int lane = std::countr_zero(left);
        offer(lane, {first.t[lane], base + csg.assembly.first_primitive[first.operand[lane]] + first.face[lane], 0.0, 0.0,
                     (first.entering >> lane & 1) != 0});
      }
    }
    if (first.unsure != 0) one_by_one(object, rays, base, first.unsure);
  }

  // As scene/trace.cpp does it for one.
  void visit_flat(const Instance& instance, const Flat& flat, const RayLanes& rays, uint64_t primitive, uint32_t lanes) {
    const glm::dmat3& m = instance.to_local.linear;
    Double8 o[3];
    for (int i = 0; i < 3; ++i) o[i] = rays.line.origin[i] - instance.to_local.origin[i];
    auto row = [&](const Double8 (&v)[3], int i) { return fma(m[0][i], v[0], fma(m[1][i], v[1], fma(m[2][i], v[2], 0.0))); };
    const Double8 direction = row(rays.line.direction, 1), t = -row(o, 1) / direction;
    uint32_t met = lanes & bits((t > t_min_) & (t <= t_max_)) & ~bits(direction == 0.0);
    if (met == 0) return;
    const Double8 x = fma(t, row(rays.line.direction, 0), row(o, 0)), z = fma(t, row(rays.line.direction, 2), row(o, 2));
    for (; met != 0; met &= met - 1) {
      const int lane = std::countr_zero(met);
      if (!covers(flat, x[lane], z[lane])) continue;
      if (kAny)
        open_ &= ~(1u << lane);
      else
        offer(lane, {t[lane], primitive, 0.0, 0.0, direction[lane] < 0.0});
    }
  }

  void visit_instance(const Assembly& group, uint32_t index, const RayLanes& rays, uint64_t base, uint32_t lanes) {
    lanes &= open_;
    if (lanes == 0) return;
    const Instance& instance = group.instances[index];
    const Object& inner = scene_.objects[instance.object];
    const uint64_t first = base + group.first_primitive[index];
    if (kind_of(inner) == Kind::Flat) return visit_flat(instance, scene_.flats[inner.index], rays, first, lanes);
    RayLanes local;
    bring(instance, rays.line, local.line);
    if (!instance.turned) {
      local.directions = rays.directions;
      return visit(inner, local, first, lanes);
    }
    const DirectionLanes directions(local.line.direction);
    local.directions = &directions;
    visit(inner, local, first, lanes);
  }

  void visit_group(const Object& object, const RayLanes& rays, uint64_t base, uint32_t lanes) {
    TILECAST_COUNT(group);
    const Assembly& group = scene_.groups[object.index];
    const size_t count = group.instances.size();
    if (group.all_at_once) {
      for (uint32_t i = 0; i < count; ++i) visit_instance(group, i, rays, base, lanes);
      return;
    }
    if (count > kLanes && !group.wide) return one_by_one(object, rays, base, lanes);
    FloatLines lines;
    lanes &= lines.enter(group.frame, rays);
    if (lanes == 0) return;
    const Float8 s_min = lines.s_below(t_min_);
    Float8 s_max = lines.s_above(t_max_);
    auto clip = [&](const float(&lo)[3], const float(&hi)[3]) {
      Float8 from = s_min, to = s_max;
      return bits(clip_to_box(lo, hi, lines, from, to)) & lanes & open_;
    };
    if (count <= kLanes) {
      for (uint32_t i = 0; i < count; ++i) {
        const float lo[3] = {group.few.lo[0][i], group.few.lo[1][i], group.few.lo[2][i]};
        const float hi[3] = {group.few.hi[0][i], group.few.hi[1][i], group.few.hi[2][i]};
        visit_instance(group, i, rays, base, clip(lo, hi));
        if (!kAny) s_max = lines.s_above(t_max_);
      }
      return;
    }
    auto last = [&] { return greatest(lanes_of(lanes & open_) ? s_max : all(-kNowhere)); };
    float farthest = last();
    group.wide->traverse_together(RayBeam(lines, lanes, s_min), lanes, farthest, clip, [&](uint32_t index, uint32_t met) {
      visit_instance(group, index, rays, base, met);
      if (!kAny) s_max = lines.s_above(t_max_);
      farthest = last();
    });
  }

  const Scene& scene_;
  LineLanes lines_;
  Double8 t_min_, t_max_;
  Hit* best_;
  uint32_t open_;  // kAny: those that have hit nothing yet
};

}  // namespace

bool has_lanes(const Scene& scene) {
  // Of many operands, too: what is drawn, brought into its space and shaded together then costs less.
  return built_with("csg") &&
         std::any_of(scene.csgs.begin(), scene.csgs.end(), [](const Csg& csg) { return csg.filter.usable(); });
}

void closest(const Scene& scene, std::span<const Ray> rays, Hit* hits) {
  for (size_t first = 0; first < rays.size(); first += kLanes) {
    const int count = static_cast<int>(std::min<size_t>(kLanes, rays.size() - first));
    Packet<false>(scene, &rays[first], count, hits + first).run();
  }
}

void occluded(const Scene& scene, std::span<const Ray> rays, bool* found) {
  for (size_t first = 0; first < rays.size(); first += kLanes) {
    const int count = static_cast<int>(std::min<size_t>(kLanes, rays.size() - first));
    Packet<true> packet(scene, &rays[first], count, nullptr);
    packet.run();
    for (int lane = 0; lane < count; ++lane) found[first + lane] = packet.found(lane);
  }
}

}  // namespace tilecast
