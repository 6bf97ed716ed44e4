// Light from all around, as an equirectangular image: rows from +y down to -y; the middle of a row looks along -z, its
// right half towards +x. So a panorama that looks along -z shows the image itself.
//
// Between the centres of pixels the radiance is interpolated. Directions are sampled in proportion to the luminance,
// averaged over each pixel as interpolated, and to solid angle, so that the density is constant over a pixel.
#pragma once

#include <vector>

#include "base/guide.h"
#include "base/vec.h"

namespace tilecast {

class Environment {
 public:
  // pixels: radiance, row by row. rotation: degrees about +y, counter-clockwise as seen from above.
  // Throws Error where sizes or values are out of range; values below 0 count as 0.
  Environment(std::vector<Vec3f> pixels, int width, int height, double rotation);

  // From a direction of length 1, pointing outwards.
  Rgb radiance(const Vec3& direction) const;

  struct Sample {
    Vec3 direction;
    double pdf;  // per solid angle
  };
  Sample sample(const Vec2& u) const;
  double pdf(const Vec3& direction) const;

  bool black() const { return !(total_ > 0.0); }
  double fluence() const { return total_; }  // luminance summed over all directions, W/m^2

 private:
  struct Place {
    double across, down;  // in pixels from the top left corner
  };
  Place place_of(const Vec3& direction) const;
  double density(int column, int row) const;
  const Vec3f& pixel(int column, int row) const { return pixels_[size_t(row) * width_ + column]; }

  std::vector<Vec3f> pixels_;
  int width_, height_;
  double rotation_;                 // turns
  std::vector<double> across_;      // [height, width]: sum of mean luminances up to and with this pixel of its row
  std::vector<double> down_;        // [height]: times solid angle, up to and with this row
  std::vector<Guide> to_column_;    // [height]: to all pixels of a row but the last
  Guide to_row_;                    // to all rows but the last
  std::vector<double> edges_;       // [height + 1]: y of a direction at the upper edge of a row
  double total_ = 0.0;
};

}  // namespace tilecast
