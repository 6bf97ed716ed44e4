// Ray queries over the scene's objects.
#pragma once

#include "scene/scene.h"

namespace tilecast {

struct Hit {
  static constexpr uint64_t kNone = ~uint64_t(0);

  double t = kInfinity;
  uint64_t primitive = kNone;  // number in the scene, instances multiplied out
  double u = 0.0, v = 0.0;     // triangles: weights of the second and third vertex
  bool entering = false;       // the ray goes into the object (against its outward normal)

  bool found() const { return primitive != kNone; }
  // Hits are ordered by (t, primitive), so that ties are the same in every accelerator.
  bool before(const Hit& other) const { return t < other.t || (t == other.t && primitive < other.primitive); }
};

struct Crossing : Hit {
  double error = 0.0;    // bound on the error of t
  uint32_t operand = 0;  // of a CSG
};

// The first hit in t_min < t <= t_max.
Hit closest(const Scene& scene, const Ray& ray);

// Whether anything is hit in t_min < t <= t_max.
bool occluded(const Scene& scene, const Ray& ray);

// All crossings of the whole line, both ways, sorted. Primitives without an inside (open surfaces) are crossed too.
void crossings(const Scene& scene, const Ray& line, std::vector<Crossing>& out);

// The same for one object; primitives are numbered from `base`.
void closest(const Scene& scene, const Object& object, const Ray& ray, uint64_t base, Hit& best);
bool occluded(const Scene& scene, const Object& object, const Ray& ray);
void crossings(const Scene& scene, const Object& object, const Ray& line, uint64_t base, std::vector<Crossing>& out);

}  // namespace tilecast
