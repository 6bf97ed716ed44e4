// The dielectrics that a ray is inside of, and which of them counts where they overlap: Schmidt and Budge, "Simple
// Nested Dielectrics in Ray Traced Images", JGT 7(2), 2002. Of equal priority the one entered last counts.
#pragma once

#include <algorithm>

#include "base/built.h"
#include "base/elementary.h"
#include "scene/surface.h"

namespace tilecast {

// What lies on the two sides of a surface.
struct Boundary {
  double eta = 1.0;                  // index of refraction behind the surface over that in front of it
  const Material* beside = nullptr;  // the medium on the side of the surface that is not its own; null: vacuum
  bool entering = true;              // light comes from that side
  bool real = true;                  // false: another medium counts on both sides, and light goes straight on
};

inline bool refracts(const Material& material) { return built_with("dielectric") && material.refracts; }

// Light passes through it, or a part of it.
inline bool passable(const Material& material) {
  return refracts(material) || (built_with("opacity") && material.opacity < 1.0);
}

// Beer's law over a distance in metres, infinity among them.
inline Rgb transmittance(const Material& medium, double distance) {
  Rgb out(1.0);
  for (int i = 0; i < 3; ++i)
    if (double a = medium.absorption[i]; a > 0.0) out[i] = exp_negative(-a * distance);
  return out;
}

class Media {
 public:
  static constexpr int kMost = 16;

  Media() = default;
  Media(const Media& other) { *this = other; }
  Media& operator=(const Media& other) {  // no more than there is: rays carry it along
    if (!built_with("dielectric")) return *this;
    count_ = other.count_;
    if (built_with("dispersion")) shift_ = other.shift_, split_ = other.split_;
    std::copy_n(other.stack_, count_, stack_);
    return *this;
  }

  bool empty() const { return !built_with("dielectric") || count_ == 0; }
  // The one that counts; null: vacuum.
  const Material* current() const { return !empty() ? stack_[count_ - 1].material : nullptr; }
  double ior() const { return !empty() ? ior(*current()) : 1.0; }
  double ior(const Material& material) const {
    return built_with("dispersion") ? material.ior + material.dispersion * shift_ : material.ior;
  }

  // Whether light of all wavelengths meets a surface of this material where it is refracted by wavelength.
  bool splits(const Material& material) const {
    if (split_ || !refracts(material)) return false;
    bool disperses = material.dispersion != 0.0;
    for (int i = 0; i < count_; ++i) disperses |= stack_[i].material->dispersion != 0.0;
    return disperses;
  }
  // From here on there is one wavelength; see optics/spectrum.h.
  void split(double shift) { shift_ = shift, split_ = true; }

  // What a ray meets at the surface of a material, on its way in or out.
  Boundary at(const Material& material, bool entering) const {
    if (!refracts(material)) return {};
    const Material* before = current();
    if (entering) {
      bool hidden = before && (before == &material || before->priority > material.priority);
      return {ior(material) / ior(), before, true, !hidden};
    }
    const int left = innermost(&material);
    const Material* outside = before;
    if (left >= 0 && left == count_ - 1 && stack_[left].times == 1) outside = left > 0 ? stack_[left - 1].material : nullptr;
    bool hidden = left >= 0 ? outside == before : before && before->priority > material.priority;
    return {(outside ? ior(*outside) : 1.0) / ior(material), outside, false, !hidden};
  }
  // Goes through the surface of a material. Throws SampleError where more than kMost are entered one in the other, of which
  // no two that follow each other are the same.
  void cross(const Material& material, bool entering) {
    if (!refracts(material)) return;
    if (entering)
      enter(&material);
    else
      leave(&material);
  }
  Rgb transmittance(double distance) const {
    return built_with("absorption") && !empty() ? tilecast::transmittance(*current(), distance) : Rgb(1.0);
  }

 private:
  struct Entered {
    const Material* material;
    uint32_t times;  // one after the other
  };

  void enter(const Material* material) {
    int i = count_;
    while (i > 0 && stack_[i - 1].material->priority > material->priority) --i;
    if (i > 0 && stack_[i - 1].material == material) {
      ++stack_[i - 1].times;
      return;
    }
    if (count_ == kMost) refuse();
    std::copy_backward(stack_ + i, stack_ + count_, stack_ + count_ + 1);
    stack_[i] = {material, 1};
    ++count_;
  }
  // The place of the innermost medium of this material; -1 where there is none.
  int innermost(const Material* material) const {
    int i = count_ - 1;
    while (i >= 0 && stack_[i].material != material) --i;
    return i;
  }
  void leave(const Material* material) {
    const int i = innermost(material);
    if (i < 0 || --stack_[i].times > 0) return;
    int next = i + 1;
    if (i > 0 && next < count_ && stack_[i - 1].material == stack_[next].material) stack_[i - 1].times += stack_[next++].times;
    std::copy(stack_ + next, stack_ + count_, stack_ + i);
    count_ -= next - i;
  }
  [[noreturn]] static void refuse();

  int count_ = 0;
  bool split_ = false;
  double shift_ = 0.0;  // of the wavelength, from that for which indices are told
  Entered stack_[kMost];  // by priority; of one priority, in the order of entering
};

// Stands for Media where there are none.
struct NoMedia {
  Rgb transmittance(double) const { return Rgb(1.0); }
  Boundary at(const Material&, bool) const { return {}; }
  void cross(const Material&, bool) {}
};

// Whether light passes through some of the scene's surfaces. Kernels are templates of it: those for scenes where it does
// not know of no media.
inline bool passable(const Scene& scene) {
  return (built_with("dielectric") && scene.dielectrics) || (built_with("opacity") && scene.see_through);
}
template <bool kPassable>
using MediaOf = std::conditional_t<kPassable, Media, NoMedia>;

// The dielectrics around a point, from the crossings of a line through it.
Media media_at(const Scene& scene, const Vec3& point);

}  // namespace tilecast
