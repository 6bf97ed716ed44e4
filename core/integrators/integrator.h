// Radiance along one camera ray. A sample depends on the scene, the pixel and the sample index, and on nothing else.
#pragma once

#include <span>

#include "base/sampler.h"
#include "shading/medium.h"

namespace tilecast {

struct RayCounts {
  uint64_t camera = 0, bounce = 0, shadow = 0;
};

// What goes along from sample to sample of a chunk; no sample depends on it.
struct Tracing {
  RayCounts counts;
  Occluders occluders;
};

// Whose part of a sample what shines at the first surface is, before the path is scattered: see seen_emission.
enum class Seen : uint8_t { ByPath, Apart };

// What shines at the first surface along a camera ray, where light does not go straight through that; the rest is the
// path's.
Rgb seen_emission(const Scene& scene, const Ray& ray, Tracing& tracing);

// Path tracing with next-event estimation, multiple importance sampling (power heuristic) and roulette. The integrator
// "direct" is the same with two segments at most: what shines, and what is lit by it.
Rgb trace_path(const Scene& scene, const Ray& ray, const Media& media, Sampler& sampler, Tracing& tracing,
               Seen seen = Seen::ByPath);

// How far a path has come, before it meets its next surface.
struct PathState {
  Rgb sum{0.0}, throughput{1.0};
  double scale = 1.0;     // of radiance by refraction, which roulette must not mistake for absorption
  double bsdf_pdf = 0.0;  // of the direction that led here; 0: no light could have been sampled instead
  LitPlace from;          // where it was taken; asked where there are several lights, or one that is a ball
  int depth = 1;          // of the segment to come
};
// The rest of such a path, along a ray of that segment, for which numbers have been taken from the sampler.
Rgb continue_path(const Scene& scene, const Ray& ray, const Media& media, Sampler& sampler, Tracing& tracing, Seen seen,
                  const PathState& state);

// Whitted, "An Improved Illumination Model for Shaded Display", CACM 23(6), 1980: direct light, mirror and refracted
// rays followed recursively, no diffuse interreflection. Shadow rays pass through dielectrics unbent, weakened at
// their surfaces and inside.
Rgb trace_whitted(const Scene& scene, const Ray& ray, const Media& media, Sampler& sampler, Tracing& tracing);

// The same for many rays, of which neighbours should be alike; it pays where the scene has lanes (scene/packet.h).
struct CameraRay {
  Ray ray;
  const Media* media;  // around its origin
  Sampler sampler;
  Rgb value{0.0};      // what is found
};
void trace_whitted(const Scene& scene, std::span<CameraRay> rays, Tracing& tracing);

// Which share of the hemisphere above the first hit, weighted by the cosine, is free of anything within
// Scene::ao_distance; 1 where nothing is hit.
Rgb trace_ambient_occlusion(const Scene& scene, const Ray& ray, Sampler& sampler, RayCounts& counts);

// What the ray meets, as a colour, without light, materials or shadows; see views.cpp.
Rgb trace_view(const Scene& scene, const Ray& ray, RayCounts& counts);

inline Rgb radiance(const Scene& scene, const Ray& ray, const Media& media, Sampler& sampler, Tracing& tracing,
                    Seen seen = Seen::ByPath) {
  switch (scene.integrator) {
    case Integrator::Path:
    case Integrator::Direct: return trace_path(scene, ray, media, sampler, tracing, seen);
    case Integrator::Whitted: return trace_whitted(scene, ray, media, sampler, tracing);
    case Integrator::AmbientOcclusion: return trace_ambient_occlusion(scene, ray, sampler, tracing.counts);
    default: return trace_view(scene, ray, tracing.counts);
  }
}

}  // namespace tilecast
