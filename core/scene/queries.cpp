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

constexpr size_t kBatch = 1 << 16;

// ask(first, rays, answers) for stretches of rays, each brought into the space of the one mesh that a scene consists of,
// and answered by that mesh at once, which is faster than one by one; false where the scene is another.
template <class Answer, class Ask>
bool for_each_batch(const Scene& scene, const RaySpan& rays, const Pause& pause, Ask&& ask) {
  const Object& root = scene.objects[scene.root];
  if (root.kind != Kind::Group || scene.groups[root.index].instances.size() != 1) return false;
  const Instance& instance = scene.groups[root.index].instances[0];
  const Object& object = scene.objects[instance.object];
  if (object.kind != Kind::Mesh || !scene.meshes[object.index].gains_by_batches()) return false;
  std::vector<Ray> local;
  std::vector<Answer> answers;
  for (size_t first = 0; first < rays.size(); first += kBatch) {
    pause();
    const size_t count = std::min(kBatch, rays.size() - first);
    local.clear();
    for (size_t i = first; i < first + count; ++i) local.push_back(instance.local(rays[i]));
    answers.resize(count);
    ask(scene.meshes[object.index], first, local, answers);
  }
  return true;
}

}  // namespace

HitArrays closest(const Scene& scene, const RaySpan& rays, const Pause& pause) {
  size_t n = rays.size();
  HitArrays out{std::vector<double>(n, kInfinity), std::vector<double>(n), std::vector<double>(n),
                std::vector<int64_t>(n, -1), std::vector<int64_t>(n, -1), std::vector<Vec3>(n, Vec3(0.0))};
  auto put = [&](size_t i, const Ray& ray, const Hit& hit) {
    out.t[i] = hit.t;
    out.u[i] = hit.u;
    out.v[i] = hit.v;
    std::tie(out.object[i], out.primitive[i]) = name(scene, hit.primitive);
    out.normal[i] = resolve(scene, ray, hit).normal;
  };
  if (for_each_batch<FaceHit>(scene, rays, pause, [&](const AcceleratedMesh& mesh, size_t first, const auto& local, auto& hits) {
        mesh.closest(local, hits.data());
        for (size_t i = 0; i < hits.size(); ++i)
          if (const FaceHit& hit = hits[i]; hit.face != FaceHit::kNone)
            put(first + i, rays[first + i], {hit.t, hit.face, hit.u, hit.v, hit.entering});
      }))
    return out;
  for_each_ray(rays, pause, [&](size_t i, const Ray& ray) {
    if (Hit hit = closest(scene, ray); hit.found()) put(i, ray, hit);
  });
  return out;
}

std::vector<uint8_t> occluded(const Scene& scene, const RaySpan& rays, const Pause& pause) {
  std::vector<uint8_t> out(rays.size());
  if (for_each_batch<uint32_t>(scene, rays, pause, [&](const AcceleratedMesh& mesh, size_t first, const auto& local, auto& faces) {
        mesh.occluded(local, faces.data());
        for (size_t i = 0; i < faces.size(); ++i) out[first + i] = faces[i] != FaceHit::kNone;
      }))
    return out;
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
