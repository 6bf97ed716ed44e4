#include "scene/camera.h"

#include "base/check.h"

namespace tilecast {
namespace {

// The side of a pixel at a distance of 1.
double pixel_of(double fov, int height) {
  if (!(fov > 0.0 && fov < 180.0)) throw Error("fov: must lie between 0 and 180 degrees, got " + text(fov));
  return 2.0 * tan_2pi(fov / 720.0) / height;
}

}  // namespace

Camera::Camera(Kind kind, const View& view, double pixel)
    : kind_(kind), position_(view.position), width_(view.width), height_(view.height) {
  if (width_ < 1 || height_ < 1) throw Error("image must have at least one pixel");
  if (!(max_abs(position_) <= kLongest)) throw Error("position: must be finite and at most 1e100");
  Vec3 forward = view.target - position_;
  if (!(max_abs(forward) > 0.0) || !is_finite(forward)) throw Error("target: must differ from position");
  forward = glm::normalize(forward / max_abs(forward));
  if (!(max_abs(view.up) > 0.0) || !is_finite(view.up)) throw Error("up: must not be zero");
  Vec3 right = glm::cross(forward, view.up / max_abs(view.up));
  if (!(glm::length(right) > 1e-9)) throw Error("up: must not point along the line of sight");
  right = glm::normalize(right);
  forward_ = forward;
  right_ = right * pixel;
  down_ = glm::cross(forward, right) * pixel;
}

Camera Camera::perspective(const View& view, double fov) {
  return Camera(Kind::Perspective, view, pixel_of(fov, view.height));
}

Camera Camera::orthographic(const View& view, double extent) {
  check_positive(extent, "height");
  return Camera(Kind::Orthographic, view, extent / view.height);
}

Camera Camera::thin_lens(const View& view, double fov, double aperture, double focus_distance) {
  if (!(aperture >= 0.0 && aperture <= kLongest))
    throw Error("aperture: must lie between 0 and 1e100, got " + text(aperture));
  check_positive(focus_distance, "focus_distance");
  const double pixel = pixel_of(fov, view.height);
  Camera camera(Kind::ThinLens, view, pixel);
  camera.lens_right_ = camera.right_ * (aperture / pixel);
  camera.lens_down_ = camera.down_ * (aperture / pixel);
  camera.focus_ = focus_distance;
  return camera;
}

bool Camera::image_point(const Vec3& place, Vec2& out) const {
  if (kind_ != Kind::Perspective && kind_ != Kind::Orthographic) return false;
  const Vec3 from = place - position_;
  const double ahead = glm::dot(from, forward_);
  if (!(ahead > 0.0)) return false;
  const double depth = kind_ == Kind::Perspective ? ahead : 1.0;
  out = {0.5 * width_ + glm::dot(from, right_) / (glm::dot(right_, right_) * depth),
         0.5 * height_ + glm::dot(from, down_) / (glm::dot(down_, down_) * depth)};
  return true;
}

Camera Camera::panorama(const View& view) { return Camera(Kind::Panorama, view, 1.0); }

Vec3 Camera::around(double right, double down) const {
  double sine, cosine, below, ahead;
  sincos_2pi(right - std::floor(right), sine, cosine);
  sincos_2pi(down - std::floor(down), below, ahead);
  return glm::normalize(ahead * (cosine * forward_ + sine * right_) + below * down_);
}

}  // namespace tilecast
