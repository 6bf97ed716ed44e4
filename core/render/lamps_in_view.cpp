#include "render/lamps_in_view.h"

namespace tilecast {
namespace {

constexpr uint32_t kLooks = 8;       // rays for each sample
constexpr size_t kMostLamps = 64, kMostPieces = 16;  // of a lamp: this is found out for every chunk
constexpr double kMostOfImage = 1.0 / 32;  // of its pixels: lamps that fill more have less edge than inside
constexpr uint32_t kOwnPoints = 0x6c616d70;  // so that they are others than those of the paths

}  // namespace

LampsInView::LampsInView(const Scene& scene) {
  if (!built_with("area_lights") || scene.lights.areas.size() > kMostLamps) return;
  if (scene.integrator != Integrator::Path && scene.integrator != Integrator::Direct) return;
  const Camera& camera = scene.camera;
  const double reach = PixelFilter::radius(scene.filter.kind());  // of a pixel's samples, from its middle
  double pixels = 0.0;
  for (const AreaLight& lamp : scene.lights.areas) {
    if (lamp.pieces.size() > kMostPieces) continue;
    const Box box = lamp.bounds().box;
    Vec2 lo(kInfinity), hi(-kInfinity);
    bool in_front = true;
    for (int i = 0; i < 8; ++i) {
      Vec2 corner;
      in_front &= camera.image_point(box.corner(i), corner);
      lo = glm::min(lo, corner), hi = glm::max(hi, corner);
    }
    if (!in_front) {
      windows_.clear();
      return;
    }
    auto pixel = [](double at, int size) { return static_cast<int>(std::clamp(at, 0.0, double(size))); };
    auto first = [&](double at, int size) { return pixel(std::ceil(at - 0.5 - reach), size); };
    auto past = [&](double at, int size) { return pixel(std::floor(at - 0.5 + reach) + 1.0, size); };
    const Window window{first(lo.x, camera.width()), first(lo.y, camera.height()), past(hi.x, camera.width()),
                        past(hi.y, camera.height())};
    pixels += double(window.right - window.left) * (window.bottom - window.top);
    windows_.push_back(window);
  }
  if (pixels > kMostOfImage * camera.width() * camera.height()) windows_.clear();
}

bool LampsInView::at(int x, int y) const {
  for (const Window& w : windows_)
    if (x >= w.left && x < w.right && y >= w.top && y < w.bottom) return true;
  return false;
}

Rgb LampsInView::look(const Scene& scene, uint32_t x, uint32_t y, uint32_t sample, Tracing& tracing) {
  Rgb sum(0.0);
  for (uint32_t i = 0; i < kLooks; ++i) {
    Sampler sampler(x, y, (sample / 2 * kLooks + i) * 2 + sample % 2, scene.seed ^ kOwnPoints, scene.sampling);
    const CameraSample seen = sample_camera(scene, x, y, sampler);
    sum += seen.weight * seen_emission(scene, seen.ray, tracing);
  }
  return sum / double(kLooks);
}

}  // namespace tilecast
