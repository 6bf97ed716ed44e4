// Where the image shows lamps: the few pixels whose brightness depends most on where in the pixel a sample goes.
//
// At a lamp's edge a sample has all of its radiance or none, and in an image of a lit room most of the error is there. A
// ray that looks for what shines costs a fraction of a path, so there each sample's own part of it is the mean of many.
// Which pixels these are is decided by the scene alone, never by samples, which would make the image too bright or too dark.
#pragma once

#include "render/camera_sample.h"
#include "integrators/integrator.h"

namespace tilecast {

class LampsInView {
 public:
  explicit LampsInView(const Scene& scene);

  // Whether the pixel may show one's edge.
  bool at(int x, int y) const;

  // What shines in the pixel, for one of its samples: the mean over kLooks points of their own. Weighed by the filter.
  static Rgb look(const Scene& scene, uint32_t x, uint32_t y, uint32_t sample, Tracing& tracing);

 private:
  struct Window {
    int left, top, right, bottom;  // pixels; right and bottom are past its end
  };
  std::vector<Window> windows_;
};

}  // namespace tilecast
