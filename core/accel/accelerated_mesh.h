// A mesh under an accelerator, its triangles copied in the order of the leaves.
#pragma once

#include "accel/accelerator.h"
#include "geometry/mesh.h"

namespace tilecast {

class AcceleratedMesh {
 public:
  AcceleratedMesh(Mesh mesh, const AcceleratorChoice& choice);

  const Mesh& mesh() const { return mesh_; }
  const Accelerator& accelerator() const { return accelerator_; }
  uint64_t bytes() const { return accelerator_.stats().bytes + triangles_.size() * sizeof(Triangle); }

  // Calls report(face, TriangleHit) for the triangles that the ray crosses in t_min < t <= t_max, and for no others
  // that matter: report may lower t_max, and ends the search by returning true. A triangle may be reported more than
  // once where the accelerator does not visit once.
  template <class Cost, class Report>
  bool intersect(const Ray& ray, double t_min, const double& t_max, Cost& cost, Report&& report) const {
    FrameRay local;
    if (!enter_frame(mesh_.frame, ray, local)) return false;
    float s_max = local.s_above(t_max);
    return accelerator_.traverse(local, local.s_below(t_min), s_max, cost, [&](uint32_t first, uint32_t count) {
      for (uint32_t i = first; i < first + count; ++i) {
        TriangleHit hit;
        if (!tilecast::intersect(local, triangles_[i], hit)) continue;
        if (!(hit.t > t_min && hit.t <= t_max)) continue;
        if (report(accelerator_.order()[i], hit)) return true;
        s_max = local.s_above(t_max);
      }
      return false;
    });
  }
  template <class Report>
  bool intersect(const Ray& ray, double t_min, const double& t_max, Report&& report) const {
    NoCost free;
    return intersect(ray, t_min, t_max, free, report);
  }

 private:
  Mesh mesh_;
  Accelerator accelerator_;
  std::vector<Triangle> triangles_;
};

}  // namespace tilecast
