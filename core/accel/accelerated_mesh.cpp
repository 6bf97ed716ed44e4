#include "accel/accelerated_mesh.h"

#include <chrono>

namespace tilecast {

AcceleratedMesh::AcceleratedMesh(Mesh mesh, const AcceleratorChoice& choice) : mesh_(std::move(mesh)) {
  std::vector<FrameBox> boxes;
  boxes.reserve(mesh_.faces.size());
  for (uint32_t i = 0; i < mesh_.faces.size(); ++i) boxes.push_back(FrameBox::around(mesh_.triangle(i)));
  PrimitiveSet primitives;
  primitives.boxes = boxes;
  primitives.mesh = &mesh_;
  accelerator_ = Accelerator::build(choice, primitives);
  if (accelerator_.is_hierarchy()) {
    const auto start = std::chrono::steady_clock::now();
    wide_ = WideBvh::fold(accelerator_.hierarchy(), accelerator_.order(), mesh_, choice.threads);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    accelerator_.give_way(wide_->nodes().size(), wide_->bytes(), seconds.count());
    return;
  }
  triangles_.reserve(accelerator_.order().size());
  for (uint32_t face : accelerator_.order()) triangles_.push_back(mesh_.triangle(face));
}

void AcceleratedMesh::closest(std::span<const Ray> rays, FaceHit* hits) const {
  if (wide_) return tilecast::closest(*wide_, mesh_.frame, rays, hits);
  NoCost free;
  for (size_t i = 0; i < rays.size(); ++i) hits[i] = closest(rays[i], free);
}

void AcceleratedMesh::occluded(std::span<const Ray> rays, uint32_t* faces) const {
  if (wide_) return tilecast::occluded(*wide_, mesh_.frame, rays, faces);
  for (size_t i = 0; i < rays.size(); ++i) faces[i] = occluded(rays[i]);
}

void AcceleratedMesh::all_hits(const Ray& ray, std::vector<FaceHit>& hits) const {
  if (wide_) return tilecast::all_hits(*wide_, mesh_.frame, ray, hits);
  NoCost free;
  walk(ray, ray.t_min, ray.t_max, free, [&](uint32_t face, const TriangleHit& hit) {
    hits.push_back({hit.t, hit.u, hit.v, face, hit.entering});
    return false;
  });
}

}  // namespace tilecast
