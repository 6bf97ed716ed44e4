// The pinhole camera: right-handed, looks from `position` to `target`.
#pragma once

#include "base/error.h"
#include "base/ray.h"

namespace tilecast {

class Camera {
 public:
  Camera() : Camera(Vec3(0, 0, 1), Vec3(0), Vec3(0, 1, 0), 40.0, 1, 1) {}

  // fov: degrees, across the image's height. width, height: pixels.
  Camera(const Vec3& position, const Vec3& target, const Vec3& up, double fov, int width, int height)
      : position_(position), width_(width), height_(height) {
    if (width < 1 || height < 1) throw Error("image must have at least one pixel");
    if (!(fov > 0.0 && fov < 180.0)) throw Error("camera.fov must lie between 0 and 180 degrees");
    Vec3 forward = target - position;
    if (!(max_abs(forward) > 0.0) || !is_finite(forward)) throw Error("camera.target must differ from camera.position");
    forward = glm::normalize(forward / max_abs(forward));
    if (!(max_abs(up) > 0.0) || !is_finite(up)) throw Error("camera.up must not be zero");
    Vec3 right = glm::cross(forward, up / max_abs(up));
    if (!(glm::length(right) > 1e-9)) throw Error("camera.up must not point along the line of sight");
    right = glm::normalize(right);
    double half = std::tan(0.5 * fov * (kPi / 180.0));
    forward_ = forward;
    right_ = right * (2.0 * half / height);
    down_ = glm::cross(forward, right) * (2.0 * half / height);
  }

  // Through the image point (x, y) in pixels from the top left corner. The direction has length 1.
  Ray ray(double x, double y) const {
    return {position_, glm::normalize(forward_ + right_ * (x - 0.5 * width_) + down_ * (y - 0.5 * height_))};
  }

  int width() const { return width_; }
  int height() const { return height_; }
  const Vec3& position() const { return position_; }

 private:
  Vec3 position_, forward_, right_, down_;
  int width_, height_;
};

}  // namespace tilecast
