#include "scene/trace.h"

#include "base/counters.h"
#include "scene/csg.h"

namespace tilecast {
namespace {

// Visits the instances whose boxes the ray meets before t_max; visit(instance index, ray in its space) may lower t_max
// and ends the visit by returning true.
template <class Visit>
bool visit_instances(const Assembly& assembly, const Ray& ray, const double& t_max, Visit&& visit) {
  TILECAST_COUNT(group);
  FrameRay local;
  if (!enter_frame(assembly.frame, ray, local)) return false;
  float s_max = local.s_above(t_max);
  return assembly.accelerator.traverse(local, local.s_below(ray.t_min), s_max, [&](uint32_t first, uint32_t count) {
    for (uint32_t i = first; i < first + count; ++i) {
      uint32_t index = assembly.accelerator.order()[i];
      if (visit(index, assembly.instances[index].to_local.ray(ray))) return true;
    }
    s_max = local.s_above(t_max);
    return false;
  });
}

// What a mesh's crossing may be off by: its vertices are float, 2^-25 of the frame each.
double crossing_error(const Mesh& mesh, uint32_t face, const Ray& line) {
  Triangle triangle = mesh.triangle(face);
  Vec3 n = glm::cross(Vec3(triangle.b) - Vec3(triangle.a), Vec3(triangle.c) - Vec3(triangle.a));
  double projected = std::fabs(glm::dot(n, line.direction));
  double length = glm::length(n);
  // Nearly parallel triangles: no more than the triangle is long.
  double longest = 2.0 * mesh.frame.scale / max_abs(line.direction);
  return projected > 0.0 ? std::min(0x1p-24 * mesh.frame.scale * length / projected, longest) : longest;
}

}  // namespace

void closest(const Scene& scene, const Object& object, const Ray& ray, uint64_t base, Hit& best) {
  auto offer = [&](const Hit& hit) {
    if (hit.before(best)) best = hit;
  };
  switch (object.kind) {
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
    case Kind::Rectangle: {
      double t;
      if (intersect(scene.rectangles[object.index], ray, t) && t > ray.t_min)
        offer({t, base, 0.0, 0.0, ray.direction.y < 0.0});
      break;
    }
    case Kind::Mesh:
      TILECAST_COUNT(mesh);
      scene.meshes[object.index].intersect(ray, ray.t_min, best.t, [&](uint32_t face, const TriangleHit& hit) {
        offer({hit.t, base + face, hit.u, hit.v, hit.entering});
        return false;
      });
      break;
    case Kind::Csg:
      for (const Crossing& crossing : crossings(scene, scene.csgs[object.index], ray, base))
        if (crossing.t > ray.t_min) {
          offer(crossing);
          break;
        }
      break;
    case Kind::Group: {
      const Assembly& group = scene.groups[object.index];
      visit_instances(group, ray, best.t, [&](uint32_t i, const Ray& local) {
        closest(scene, scene.objects[group.instances[i].object], local, base + group.first_primitive[i], best);
        return false;
      });
      break;
    }
  }
}

bool occluded(const Scene& scene, const Object& object, const Ray& ray) {
  auto within = [&](double t) { return t > ray.t_min && t <= ray.t_max; };
  switch (object.kind) {
    case Kind::Solid: {
      TILECAST_COUNT(solid);
      SolidCrossing list[kMaxSolidCrossings];
      int count = crossings(scene.solids[object.index], ray, list);
      return std::any_of(list, list + count, [&](const SolidCrossing& c) { return within(c.t); });
    }
    case Kind::Rectangle: {
      double t;
      return intersect(scene.rectangles[object.index], ray, t) && within(t);
    }
    case Kind::Mesh:
      TILECAST_COUNT(mesh);
      return scene.meshes[object.index].intersect(ray, ray.t_min, ray.t_max,
                                                  [](uint32_t, const TriangleHit&) { return true; });
    case Kind::Csg: {
      const auto& list = crossings(scene, scene.csgs[object.index], ray, 0);
      return std::any_of(list.begin(), list.end(), [&](const Crossing& c) { return within(c.t); });
    }
    default: {
      const Assembly& group = scene.groups[object.index];
      return visit_instances(group, ray, ray.t_max, [&](uint32_t i, const Ray& local) {
        return occluded(scene, scene.objects[group.instances[i].object], local);
      });
    }
  }
}

void crossings(const Scene& scene, const Object& object, const Ray& line, uint64_t base, std::vector<Crossing>& out) {
  switch (object.kind) {
    case Kind::Solid: {
      TILECAST_COUNT(solid);
      SolidCrossing list[kMaxSolidCrossings];
      int count = crossings(scene.solids[object.index], line, list);
      for (int i = 0; i < count; ++i)
        out.push_back({{list[i].t, base + list[i].face, 0.0, 0.0, list[i].entering}, list[i].error});
      break;
    }
    case Kind::Rectangle: {
      double t;
      if (intersect(scene.rectangles[object.index], line, t))
        out.push_back({{t, base, 0.0, 0.0, line.direction.y < 0.0}});
      break;
    }
    case Kind::Mesh: {
      TILECAST_COUNT(mesh);
      const AcceleratedMesh& mesh = scene.meshes[object.index];
      mesh.intersect(line, -kInfinity, kInfinity, [&](uint32_t face, const TriangleHit& hit) {
        out.push_back({{hit.t, base + face, hit.u, hit.v, hit.entering}, crossing_error(mesh.mesh(), face, line)});
        return false;
      });
      break;
    }
    case Kind::Csg: {
      const auto& list = crossings(scene, scene.csgs[object.index], line, base);
      out.insert(out.end(), list.begin(), list.end());
      break;
    }
    case Kind::Group: {
      const Assembly& group = scene.groups[object.index];
      Ray whole = line;
      whole.t_min = -kInfinity;
      visit_instances(group, whole, kInfinity, [&](uint32_t i, const Ray& local) {
        crossings(scene, scene.objects[group.instances[i].object], local, base + group.first_primitive[i], out);
        return false;
      });
      break;
    }
  }
}

Hit closest(const Scene& scene, const Ray& ray) {
  Hit best;
  best.t = ray.t_max;
  closest(scene, scene.objects[scene.root], ray, 0, best);
  return best;
}

bool occluded(const Scene& scene, const Ray& ray) { return occluded(scene, scene.objects[scene.root], ray); }

void crossings(const Scene& scene, const Ray& line, std::vector<Crossing>& out) {
  out.clear();
  crossings(scene, scene.objects[scene.root], line, 0, out);
  std::sort(out.begin(), out.end(), [](const Crossing& a, const Crossing& b) { return a.before(b); });
}

}  // namespace tilecast
