// A mesh under an accelerator: a bvh or sbvh folded for vectors (accel/wide_bvh.h); for the others its triangles copied in
// the order of the leaves.
#pragma once

#include <optional>

#include "accel/accelerator.h"
#include "accel/wide_trace.h"
#include "geometry/mesh.h"

namespace tilecast {

class AcceleratedMesh {
 public:
  AcceleratedMesh(Mesh mesh, const AcceleratorChoice& choice);

  const Mesh& mesh() const { return mesh_; }
  const Accelerator& accelerator() const { return accelerator_; }
  uint64_t bytes() const { return accelerator_.stats().bytes + triangles_.size() * sizeof(Triangle); }

  // The first hit in t_min < t <= t_max, by (t, face).
  template <class Cost>
  FaceHit closest(const Ray& ray, Cost& cost) const {
    if (wide_) {
      if constexpr (std::is_same_v<Cost, NoCost>) return tilecast::closest(*wide_, mesh_.frame, ray);
      else return tilecast::closest(*wide_, mesh_.frame, ray, cost);
    }
    FaceHit best;
    double t_max = ray.t_max;
    walk(ray, ray.t_min, t_max, cost, [&](uint32_t face, const TriangleHit& hit) {
      if (hit.t == t_max && best.face < face) return false;
      best = {hit.t, hit.u, hit.v, face, hit.entering};
      t_max = hit.t;
      return false;
    });
    return best;
  }

  // A face hit in t_min < t <= t_max, or FaceHit::kNone.
  uint32_t occluded(const Ray& ray) const {
    if (wide_) return tilecast::occluded(*wide_, mesh_.frame, ray);
    uint32_t found = FaceHit::kNone;
    NoCost free;
    walk(ray, ray.t_min, ray.t_max, free, [&](uint32_t face, const TriangleHit&) {
      found = face;
      return true;
    });
    return found;
  }

  // The same for many rays; faster where it gains by batches.
  bool gains_by_batches() const { return wide_.has_value(); }
  void closest(std::span<const Ray> rays, FaceHit* hits) const;
  void occluded(std::span<const Ray> rays, uint32_t* faces) const;

  // Appends all hits in t_min < t <= t_max in no order; some more than once where the accelerator does not visit once.
  void all_hits(const Ray& ray, std::vector<FaceHit>& hits) const;
  std::vector<FaceHit> all_hits(const Ray& ray) const {
    std::vector<FaceHit> hits;
    all_hits(ray, hits);
    return hits;
  }

 private:
  // Calls report(face, TriangleHit) for the triangles that the ray crosses in t_min < t <= t_max, and for no others
  // that matter: report may lower t_max, and ends the search by returning true.
  template <class Cost, class Report>
  void walk(const Ray& ray, double t_min, const double& t_max, Cost& cost, Report&& report) const {
    FrameRay local;
    if (!enter_frame(mesh_.frame, ray, local)) return;
    float s_max = local.s_above(t_max);
    accelerator_.traverse(local, local.s_below(t_min), s_max, cost, [&](uint32_t first, uint32_t count) {
      for (uint32_t i = first; i < first + count; ++i) {
        TriangleHit hit;
        if (!intersect(local, triangles_[i], hit)) continue;
        if (!(hit.t > t_min && hit.t <= t_max)) continue;
        if (report(accelerator_.order()[i], hit)) return true;
        s_max = local.s_above(t_max);
      }
      return false;
    });
  }

  Mesh mesh_;
  Accelerator accelerator_;
  std::optional<WideBvh> wide_;
  std::vector<Triangle> triangles_;
};

}  // namespace tilecast
