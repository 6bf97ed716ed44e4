// Embree on the same triangles and rays, through its public interface: single rays and packets of 16.
#pragma once

#include <embree3/rtcore.h>

#include <span>
#include <vector>

#include "base/ray.h"
#include "bench/meshes.h"

namespace tilecast::bench {

class Embree {
 public:
  struct Options {
    bool robust = false, high_quality = false;
    int threads = 1;
  };
  Embree(const Triangles& mesh, const Options& options);
  ~Embree();
  Embree(const Embree&) = delete;

  double build_seconds() const { return seconds_; }
  long long bytes() const { return bytes_; }
  long long peak_bytes() const { return peak_; }

  // Rays are laid out beforehand, which is not timed; closest() and occluded() change what they trace.
  struct Single {
    std::vector<RTCRayHit> rays;
  };
  struct Packets {
    std::vector<RTCRayHit16> rays;
  };
  static void lay_out(std::span<const Ray> rays, Single& out);
  static void lay_out(std::span<const Ray> rays, Packets& out);

  void closest(Single& rays, size_t begin, size_t end) const;
  void closest(Packets& rays, size_t begin, size_t end, bool coherent) const;  // begin, end: of packets
  void occluded(Single& rays, size_t begin, size_t end) const;
  void occluded(Packets& rays, size_t begin, size_t end, bool coherent) const;

 private:
  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
  double seconds_ = 0.0;
  long long bytes_ = 0, peak_ = 0;
};

}  // namespace tilecast::bench
