// The dielectrics that a ray is inside of, innermost last.
#pragma once

#include "base/elementary.h"
#include "scene/surface.h"

namespace tilecast {

class Media {
 public:
  static constexpr int kMost = 16;

  Media() = default;
  Media(const Media& other) { *this = other; }
  Media& operator=(const Media& other) {  // no more than there is: rays carry it along
    count_ = other.count_;
    for (int i = 0; i < count_; ++i) stack_[i] = other.stack_[i];
    return *this;
  }

  const Material* current() const { return count_ > 0 ? stack_[count_ - 1] : nullptr; }
  double ior() const { return count_ > 0 ? current()->ior : 1.0; }

  void enter(const Material* material) {
    if (count_ < kMost) stack_[count_++] = material;
  }
  // Leaves the innermost medium of this material.
  void leave(const Material* material) {
    for (int i = count_ - 1; i >= 0; --i)
      if (stack_[i] == material) {
        for (; i + 1 < count_; ++i) stack_[i] = stack_[i + 1];
        --count_;
        return;
      }
  }
  // Beer's law over a distance in metres, infinity among them.
  Rgb transmittance(double distance) const {
    Rgb out(1.0);
    if (count_ == 0) return out;
    for (int i = 0; i < 3; ++i)
      if (double a = current()->absorption[i]; a > 0.0) out[i] = exp_negative(-a * distance);
    return out;
  }
  // The relative index of refraction at a boundary of the material, crossed inwards or outwards.
  double eta(const Material& material, bool entering) const {
    if (entering) return material.ior / ior();
    Media outside = *this;
    outside.leave(&material);
    return outside.ior() / material.ior;
  }

 private:
  const Material* stack_[kMost];
  int count_ = 0;
};

// The dielectrics around a point, from the crossings of a line through it.
Media media_at(const Scene& scene, const Vec3& point);

}  // namespace tilecast
