#include "scene/queries.h"

#include <tuple>

namespace tilecast {
namespace {

// Of a primitive of the scene: the index in the scene's list, and the number within that object.
std::pair<int64_t, int64_t> name(const Scene& scene, uint64_t primitive) {
  const Object& root = scene.objects[scene.root];
  if (root.kind != Kind::Group) return {0, static_cast<int64_t>(primitive)};
  const Assembly& list = scene.groups[root.index];
  uint32_t i = list.find(primitive);
  return {i, static_cast<int64_t>(primitive - list.first_primitive[i])};
}

template <class Ask>
void for_each_ray(const RaySpan& rays, const Pause& pause, Ask&& ask) {
  for (size_t i = 0; i < rays.size(); ++i) {
    if (i % 256 == 0) pause();
    ask(i, rays[i]);
  }
}

}  // namespace

HitArrays closest(const Scene& scene, const RaySpan& rays, const Pause& pause) {
  size_t n = rays.size();
  HitArrays out{std::vector<double>(n, kInfinity), std::vector<double>(n), std::vector<double>(n),
                std::vector<int64_t>(n, -1), std::vector<int64_t>(n, -1), std::vector<Vec3>(n, Vec3(0.0))};
  for_each_ray(rays, pause, [&](size_t i, const Ray& ray) {
    Hit hit = closest(scene, ray);
    if (!hit.found()) return;
    out.t[i] = hit.t;
    out.u[i] = hit.u;
    out.v[i] = hit.v;
    std::tie(out.object[i], out.primitive[i]) = name(scene, hit.primitive);
    out.normal[i] = resolve(scene, ray, hit).normal;
  });
  return out;
}

std::vector<uint8_t> occluded(const Scene& scene, const RaySpan& rays, const Pause& pause) {
  std::vector<uint8_t> out(rays.size());
  for_each_ray(rays, pause, [&](size_t i, const Ray& ray) { out[i] = occluded(scene, ray); });
  return out;
}

CrossingArrays crossings(const Scene& scene, const RaySpan& rays, const Pause& pause) {
  CrossingArrays out;
  out.offsets.push_back(0);
  std::vector<Crossing> list;
  for_each_ray(rays, pause, [&](size_t, const Ray& line) {
    crossings(scene, line, list);
    for (const Crossing& crossing : list) {
      auto [object, primitive] = name(scene, crossing.primitive);
      out.t.push_back(crossing.t);
      out.object.push_back(object);
      out.primitive.push_back(primitive);
      out.entering.push_back(crossing.entering);
    }
    out.offsets.push_back(static_cast<int64_t>(out.t.size()));
  });
  return out;
}

}  // namespace tilecast
