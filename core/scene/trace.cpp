#include "scene/trace.h"

#include "base/counters.h"
#include "scene/csg.h"
#include "scene/csg_search.h"
#include "scene/descend.h"
#include "scene/float_line.h"
#include "scene/trace_object.h"

namespace tilecast {
namespace {

// visit_instances for at most kLanes of them; by other means than the accelerators', to the same end.
template <bool kNearFirst, class Visit>
bool visit_few(const Assembly& assembly, const Ray& ray, const double& t_max, Visit&& visit) {
  FloatLine line;
  if (!enter_line(assembly.frame, ray, line)) return false;
  const float room = static_cast<float>(kRoom + std::fabs(line.start) * 0x1p-50);
  auto last = [&](double t) {
    float s = line.s(t);
    return s + std::fabs(s) * 0x1p-22f + room;
  };
  const float first = line.s(ray.t_min);
  Float8 from;
  Mask8 met = meets(assembly.few, line, first - std::fabs(first) * 0x1p-22f - room, last(t_max), from);
  met &= kLaneNumbers < static_cast<int>(assembly.instances.size());
  if constexpr (!kNearFirst) {
    for (unsigned left = bits(met); left != 0; left &= left - 1)
      if (visit(static_cast<uint32_t>(std::countr_zero(left)))) return true;
    return false;
  }
  from = met ? from : all(kMissed);
  for (;;) {
    const float next = least(from);
    if (next == kMissed || next > last(t_max)) return false;
    const int lane = std::countr_zero(bits(from == next));
    from = kLaneNumbers == lane ? all(kMissed) : from;
    if (visit(static_cast<uint32_t>(lane))) return true;
  }
}

// Visits the instances whose boxes the ray meets before t_max; visit(index) may lower t_max, which is worth looking at
// near ones first, and ends the visit by returning true.
template <bool kNearFirst, class Cost, class Visit>
bool visit_instances(const Assembly& assembly, const Ray& ray, const double& t_max, Cost& cost, Visit&& visit) {
  TILECAST_COUNT(group);
  if constexpr (std::is_same_v<Cost, NoCost>) {
    if (assembly.all_at_once) {
      for (uint32_t i = 0; i < assembly.instances.size(); ++i)
        if (visit(i)) return true;
      return false;
    }
    if (assembly.instances.size() <= kLanes) return visit_few<kNearFirst>(assembly, ray, t_max, visit);
  }
  FrameRay local;
  if (!enter_boxes(assembly.frame, ray, local)) return false;
  float s_max = local.s_above(t_max);
  const float s_min = local.s_below(ray.t_min);
  if (assembly.wide)
    return assembly.wide->traverse(local, s_min, s_max, cost, [&](uint32_t index) {
      const bool end = visit(index);
      s_max = local.s_above(t_max);
      return end;
    });
  return assembly.accelerator.traverse(local, s_min, s_max, cost, [&](uint32_t first, uint32_t count) {
    for (uint32_t i = first; i < first + count; ++i)
      if (visit(assembly.accelerator.order()[i])) return true;
    s_max = local.s_above(t_max);
    return false;
  });
}

// None that the build leaves out.
const Flat& flat_of(const Scene& scene, uint32_t index) {
  const Flat& flat = scene.flats[index];
  if (std::holds_alternative<Disk>(flat) ? !built_with("disk") : !built_with("rectangle")) __builtin_unreachable();
  return flat;
}

// The hit of a flat under an instance in t_min < t <= t_max. Most rays are through after two of the six coordinates.
bool intersect(const Instance& instance, const Flat& flat, const Ray& ray, double t_max, double& t, bool& entering) {
  const Vec3 origin = ray.origin - instance.to_local.origin;
  const glm::dmat3& m = instance.to_local.linear;
  const double direction = multiply_add(m, ray.direction, 0.0, 1);
  if (direction == 0.0) return false;  // in the plane: a miss
  t = -multiply_add(m, origin, 0.0, 1) / direction;
  if (!(t > ray.t_min && t <= t_max)) return false;
  entering = direction < 0.0;
  return covers(flat, std::fma(t, multiply_add(m, ray.direction, 0.0, 0), multiply_add(m, origin, 0.0, 0)),
                std::fma(t, multiply_add(m, ray.direction, 0.0, 2), multiply_add(m, origin, 0.0, 2)));
}

// By how much t moves where the line is displaced against a surface with this normal. Where they are nearly parallel, a
// small part of what the object is long: nothing is known there, and what the object's own crossings say is taken.
double moved_by(double displacement, const Vec3& normal, const Ray& line, double longest) {
  double most = 0x1p-10 * longest / max_abs(line.direction);
  double moved = displacement * glm::length(normal) / std::fabs(glm::dot(normal, line.direction));
  return moved < most ? moved : most;  // not a number: most
}

// What a mesh's crossing may be off by: float decides, and the nearest point of the triangle stands for the hit.
double crossing_error(const Mesh& mesh, uint32_t face, const Ray& line, double displacement) {
  Triangle triangle = mesh.triangle(face);
  Vec3 n = glm::cross(Vec3(triangle.b) - Vec3(triangle.a), Vec3(triangle.c) - Vec3(triangle.a));
  return moved_by(mesh.frame.sideways_error() + displacement, n, line, 2.0 * mesh.frame.scale);
}

template <class Cost>
void closest(const Scene& scene, const Object& object, const Ray& ray, uint64_t base, Hit& best, Cost& cost) {
  auto offer = [&](const Hit& hit) {
    if (hit.before(best)) best = hit;
  };
  switch (kind_of(object)) {
    case Kind::Solid: {
      TILECAST_COUNT(solid);
      SolidCrossing list[kMaxSolidCrossings];
      int count = crossings(scene.solids[object.index], ray, list);
      for (int i = 0; i < count; ++i)
        if (list[i].t > ray.t_min) {
          offer({list[i].t, base + list[i].face, 0.0, 0.0, list[i].entering});
          break;
        }
      break;
    }
    case Kind::Flat: {
      double t;
      if (intersect(flat_of(scene, object.index), ray, t) && t > ray.t_min)
        offer({t, base, 0.0, 0.0, ray.direction.y < 0.0});
      break;
    }
    case Kind::Mesh: {
      TILECAST_COUNT(mesh);
      const FaceHit hit = scene.meshes[object.index].closest({ray.origin, ray.direction, ray.t_min, best.t}, cost);
      if (hit.face != FaceHit::kNone) offer({hit.t, base + hit.face, hit.u, hit.v, hit.entering});
      break;
    }
    case Kind::Csg: {
      const Csg& csg = scene.csgs[object.index];
      if (csg.filter.usable()) {
        Crossing first;
        Filtered found = first_crossing(scene, csg, ray, ray.t_min, best.t, base, false, first);
        if (found == Filtered::Found) offer(first);
        if (found != Filtered::Unsure) break;
      }
      visit_crossings(scene, csg, ray, ray.t_min, best.t, base, [&](const Crossing& crossing) {
        if (!(crossing.t > ray.t_min)) return false;
        offer(crossing);
        return true;
      });
      break;
    }
    case Kind::Group: {
      const Assembly& group = scene.groups[object.index];
      visit_instances<true>(group, ray, best.t, cost, [&](uint32_t i) {
        const Instance& instance = group.instances[i];
        const Object& inner = scene.objects[instance.object];
        const uint64_t first = base + group.first_primitive[i];
        if (kind_of(inner) == Kind::Flat) {
          Hit hit{0.0, first};
          if (intersect(instance, flat_of(scene, inner.index), ray, best.t, hit.t, hit.entering)) offer(hit);
        } else {
          closest(scene, inner, instance.local(ray), first, best, cost);
        }
        return false;
      });
      break;
    }
  }
}

// `occluder` receives the primitive that was found first.
bool occluded(const Scene& scene, const Object& object, const Ray& ray, uint64_t base, uint64_t& occluder) {
  auto within = [&](double t) { return t > ray.t_min && t <= ray.t_max; };
  NoCost free;
  switch (kind_of(object)) {
    case Kind::Solid: {
      TILECAST_COUNT(solid);
      SolidCrossing list[kMaxSolidCrossings];
      int count = crossings(scene.solids[object.index], ray, list);
      occluder = base;
      return std::any_of(list, list + count, [&](const SolidCrossing& c) { return within(c.t); });
    }
    case Kind::Flat: {
      double t;
      occluder = base;
      return intersect(flat_of(scene, object.index), ray, t) && within(t);
    }
    case Kind::Mesh: {
      TILECAST_COUNT(mesh);
      const uint32_t face = scene.meshes[object.index].occluded(ray);
      occluder = base + face;
      return face != FaceHit::kNone;
    }
    case Kind::Csg: {
      const Csg& csg = scene.csgs[object.index];
      bool hit = false;
      occluder = base;
      if (csg.filter.usable()) {
        Crossing ignored;
        Filtered found = first_crossing(scene, csg, ray, ray.t_min, ray.t_max, base, true, ignored);
        if (found != Filtered::Unsure) return found == Filtered::Found;
      }
      visit_crossings(scene, csg, ray, ray.t_min, ray.t_max, base, [&](const Crossing& crossing) {
        hit = within(crossing.t);
        return hit || crossing.t > ray.t_max;
      });
      return hit;
    }
    default: {
      const Assembly& group = scene.groups[object.index];
      return visit_instances<false>(group, ray, ray.t_max, free, [&](uint32_t i) {
        const Instance& instance = group.instances[i];
        const Object& inner = scene.objects[instance.object];
        const uint64_t first = base + group.first_primitive[i];
        if (kind_of(inner) != Kind::Flat) return occluded(scene, inner, instance.local(ray), first, occluder);
        double t;
        bool entering;
        occluder = first;
        return intersect(instance, flat_of(scene, inner.index), ray, ray.t_max, t, entering);
      });
    }
  }
}

// Whether the object that holds one primitive (a triangle: it alone) stops the ray.
bool occluded_by(const Scene& scene, Ray ray, uint64_t primitive) {
  if (primitive >= scene.objects[scene.root].primitives) return false;
  const Object& object =
      descend<false>(scene, primitive, [&](const Instance& instance) { ray = instance.local(ray); });
  uint64_t ignored;
  if (kind_of(object) != Kind::Mesh) return occluded(scene, object, ray, 0, ignored);
  const Mesh& mesh = scene.meshes[object.index].mesh();
  FrameRay local;
  TriangleHit hit;
  return enter_frame(mesh.frame, ray, local) && intersect(local, mesh.triangle(static_cast<uint32_t>(primitive)), hit) &&
         hit.t > ray.t_min && hit.t <= ray.t_max;
}

// Sorts what was appended since `begin`, and takes out what an accelerator offered twice.
void tidy(std::vector<Crossing>& list, size_t begin, const Accelerator& accelerator) {
  if (accelerator.visits_once()) return;
  std::sort(list.begin() + begin, list.end(), [](const Crossing& a, const Crossing& b) {
    return a.before(b) || (!b.before(a) && a.entering && !b.entering);
  });
  auto end = std::unique(list.begin() + begin, list.end(), [](const Crossing& a, const Crossing& b) { return a.same_as(b); });
  list.erase(end, list.end());
}

template <class Cost>
Hit closest(const Scene& scene, const Ray& ray, Cost& cost) {
  Hit best;
  best.t = ray.t_max;
  closest(scene, scene.objects[scene.root], ray, 0, best, cost);
  return best;
}

}  // namespace

void closest(const Scene& scene, const Object& object, const Ray& ray, uint64_t base, Hit& best) {
  NoCost free;
  closest(scene, object, ray, base, best, free);
}

bool occluded(const Scene& scene, const Object& object, const Ray& ray) {
  uint64_t ignored;
  return occluded(scene, object, ray, 0, ignored);
}

Hit closest(const Scene& scene, const Ray& ray) {
  NoCost free;
  return closest<NoCost>(scene, ray, free);
}

Hit closest(const Scene& scene, const Ray& ray, TraversalCost& cost) { return closest<TraversalCost>(scene, ray, cost); }

bool occluded(const Scene& scene, const Ray& ray) {
  uint64_t ignored;
  return occluded(scene, scene.objects[scene.root], ray, 0, ignored);
}

bool occluded(const Scene& scene, const Ray& ray, uint64_t& occluder) {
  // Among few primitives, asking for one of them costs more than it saves.
  if (scene.objects[scene.root].primitives > kLanes * kLanes && occluded_by(scene, ray, occluder)) return true;
  return occluded(scene, scene.objects[scene.root], ray, 0, occluder);
}

int solid_crossings(const Scene& scene, const Object& object, const Ray& line, const LineError& line_error,
                    SolidCrossing out[kMaxSolidCrossings]) {
  const Solid& solid = scene.solids[object.index];
  int count = crossings(solid, line, out);
  for (int i = 0; i < count; ++i)
    if (double displacement = line_error.at(out[i].t); displacement > 0.0)
      out[i].error += moved_by(displacement, outward(solid, out[i].face, line.at(out[i].t)), line,
                               glm::length(object.bounds.hi - object.bounds.lo));
  return count;
}

void crossings(const Scene& scene, const Object& object, const Ray& line, uint64_t base, std::vector<Crossing>& out,
               const LineError& line_error) {
  NoCost free;
  switch (kind_of(object)) {
    case Kind::Solid: {
      TILECAST_COUNT(solid);
      SolidCrossing list[kMaxSolidCrossings];
      int count = solid_crossings(scene, object, line, line_error, list);
      for (int i = 0; i < count; ++i)
        out.push_back({{list[i].t, base + list[i].face, 0.0, 0.0, list[i].entering}, list[i].error});
      break;
    }
    case Kind::Flat: {
      double t;
      if (intersect(flat_of(scene, object.index), line, t))
        out.push_back({{t, base, 0.0, 0.0, line.direction.y < 0.0}});
      break;
    }
    case Kind::Mesh: {
      TILECAST_COUNT(mesh);
      const AcceleratedMesh& mesh = scene.meshes[object.index];
      size_t begin = out.size();
      thread_local std::vector<FaceHit> hits;
      hits.clear();
      mesh.all_hits({line.origin, line.direction, -kInfinity, kInfinity}, hits);
      for (const FaceHit& hit : hits)
        out.push_back({{hit.t, base + hit.face, hit.u, hit.v, hit.entering},
                       crossing_error(mesh.mesh(), hit.face, line, line_error.at(hit.t))});
      tidy(out, begin, mesh.accelerator());
      break;
    }
    case Kind::Csg:
      visit_crossings(scene, scene.csgs[object.index], line, -kInfinity, kInfinity, base, [&](const Crossing& crossing) {
        out.push_back(crossing);
        return false;
      });
      break;
    case Kind::Group: {
      const Assembly& group = scene.groups[object.index];
      Ray whole = line;
      whole.t_min = -kInfinity;
      size_t begin = out.size();
      visit_instances<false>(group, whole, kInfinity, free, [&](uint32_t i) {
        const Instance& instance = group.instances[i];
        crossings(scene, scene.objects[instance.object], instance.local(whole), base + group.first_primitive[i], out);
        return false;
      });
      tidy(out, begin, group.accelerator);
      break;
    }
  }
}

void crossings(const Scene& scene, const Ray& line, std::vector<Crossing>& out) {
  out.clear();
  crossings(scene, scene.objects[scene.root], line, 0, out);
  std::sort(out.begin(), out.end(), [](const Crossing& a, const Crossing& b) { return a.before(b); });
}

}  // namespace tilecast
