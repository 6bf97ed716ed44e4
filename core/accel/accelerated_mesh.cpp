#include "accel/accelerated_mesh.h"

namespace tilecast {

AcceleratedMesh::AcceleratedMesh(Mesh mesh, const AcceleratorChoice& choice) : mesh_(std::move(mesh)) {
  std::vector<FrameBox> boxes;
  boxes.reserve(mesh_.faces.size());
  for (uint32_t i = 0; i < mesh_.faces.size(); ++i) {
    Triangle t = mesh_.triangle(i);
    FrameBox box;
    for (int k = 0; k < 3; ++k) {
      box.lo[k] = std::min({t.a[k], t.b[k], t.c[k]}) - kBoxPadding;
      box.hi[k] = std::max({t.a[k], t.b[k], t.c[k]}) + kBoxPadding;
    }
    boxes.push_back(box);
  }
  PrimitiveSet primitives;
  primitives.boxes = boxes;
  primitives.mesh = &mesh_;
  accelerator_ = Accelerator::build(choice, primitives);
  triangles_.reserve(accelerator_.order().size());
  for (uint32_t face : accelerator_.order()) triangles_.push_back(mesh_.triangle(face));
}

}  // namespace tilecast
