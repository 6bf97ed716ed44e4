// Cameras: right-handed, looking from `position` to `target`.
#pragma once

#include "base/elementary.h"
#include "base/error.h"
#include "base/ray.h"
#include "base/vec_lanes.h"

namespace tilecast {

// Where a camera stands and what it makes.
struct View {
  Vec3 position, target, up;
  int width, height;  // pixels
};

class Camera {
 public:
  Camera() : Camera(Vec3(0, 0, 1), Vec3(0), Vec3(0, 1, 0), 40.0, 1, 1) {}

  // A pinhole. fov: degrees, across the image's height.
  Camera(const Vec3& position, const Vec3& target, const Vec3& up, double fov, int width, int height)
      : Camera(perspective({position, target, up, width, height}, fov)) {}
  static Camera perspective(const View& view, double fov);
  // All rays are parallel. extent: metres across the image's height.
  static Camera orthographic(const View& view, double extent);
  // A thin lens: sharp at `focus_distance` along the line of sight. aperture: the lens's radius; both in metres.
  static Camera thin_lens(const View& view, double fov, double aperture, double focus_distance);
  // All directions, equirectangular: the target in the middle, the direction of `up` along the upper edge.
  static Camera panorama(const View& view);

  // Through the image point (x, y) in pixels from the top left corner, and through a point of the lens, given in the
  // unit disk. The direction has length 1.
  Ray ray(double x, double y, const Vec2& lens = Vec2(0.0)) const {
    const double right = x - 0.5 * width_, down = y - 0.5 * height_;
    switch (kind_) {
      case Kind::Perspective: return {position_, glm::normalize(forward_ + right_ * right + down_ * down)};
      case Kind::Orthographic: return {position_ + right_ * right + down_ * down, forward_};
      case Kind::ThinLens: {
        const Vec3 aside = lens_right_ * lens.x + lens_down_ * lens.y;
        return {position_ + aside, glm::normalize(focus_ * (forward_ + right_ * right + down_ * down) - aside)};
      }
      default: return {position_, around(right / width_, 0.5 * down / height_)};
    }
  }

  // The image point of a place that a camera of one view point, or of parallel rays, sees: the inverse of ray(). False where
  // the place is not in front, and for other cameras.
  bool image_point(const Vec3& place, Vec2& out) const;

  // Of a pinhole: ray(x, y) goes along forward + (x - width / 2) right + (y - height / 2) down.
  struct Pinhole {
    Vec3 position, forward, right, down;
  };
  bool is_pinhole() const { return kind_ == Kind::Perspective; }
  Pinhole pinhole() const { return {position_, forward_, right_, down_}; }
  // The directions of eight of its rays at once, to the same bits.
  Vec3Lanes pinhole_directions(const Double8& x, const Double8& y) const {
    const Double8 right = x - 0.5 * width_, down = y - 0.5 * height_;
    return normalize(Vec3Lanes(forward_) + Vec3Lanes(right_) * right + Vec3Lanes(down_) * down);
  }

  int width() const { return width_; }
  int height() const { return height_; }
  const Vec3& position() const { return position_; }
  bool has_lens() const { return kind_ == Kind::ThinLens; }
  // Whether its rays start at several points.
  bool has_extent() const { return kind_ == Kind::ThinLens || kind_ == Kind::Orthographic; }

 private:
  enum class Kind : uint8_t { Perspective, Orthographic, ThinLens, Panorama };

  Camera(Kind kind, const View& view, double pixel);
  Vec3 around(double right, double down) const;  // turns

  Kind kind_;
  Vec3 position_, forward_, right_, down_;  // right_, down_: from pixel to pixel
  Vec3 lens_right_{0.0}, lens_down_{0.0};   // the lens's radii, metres
  double focus_ = 1.0;                      // metres
  int width_, height_;
};

}  // namespace tilecast
