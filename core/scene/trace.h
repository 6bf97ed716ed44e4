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

  bool same_as(const Crossing& c) const { return t == c.t && primitive == c.primitive && entering == c.entering; }
};

// How far a line may be off, in the space of an object that it has been brought into.
struct LineError {
  double at_origin = 0.0, per_t = 0.0;

  double at(double t) const { return at_origin + std::fabs(t) * per_t; }
};

// The first hit in t_min < t <= t_max.
Hit closest(const Scene& scene, const Ray& ray);

// The same, and what it cost is added up.
Hit closest(const Scene& scene, const Ray& ray, TraversalCost& cost);

// Whether anything is hit in t_min < t <= t_max.
bool occluded(const Scene& scene, const Ray& ray);

// The primitive that last stood before each light: neighbouring shadow rays are often stopped by the same one, which is
// then tested first (Haines and Greenberg, "The Light Buffer", CG&A 6(9), 1986). The answer does not depend on it.
class Occluders {
 public:
  Occluders() { std::fill_n(last_, kSlots, Hit::kNone); }
  uint64_t& of(size_t light) { return last_[light % kSlots]; }

 private:
  static constexpr size_t kSlots = 16;
  uint64_t last_[kSlots];
};
bool occluded(const Scene& scene, const Ray& ray, uint64_t& occluder);

// All crossings of the whole line, both ways, sorted. Primitives without an inside (open surfaces) are crossed too.
void crossings(const Scene& scene, const Ray& line, std::vector<Crossing>& out);

// The crossings of one object, appended; primitives are numbered from `base`.
void crossings(const Scene& scene, const Object& object, const Ray& line, uint64_t base, std::vector<Crossing>& out,
               const LineError& line_error = {});

// The same of a solid, with the error bounds of a line that is itself off. Returns how many.
int solid_crossings(const Scene& scene, const Object& object, const Ray& line, const LineError& line_error,
                    SolidCrossing out[kMaxSolidCrossings]);

}  // namespace tilecast
