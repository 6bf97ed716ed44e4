// One sample of the light that reaches a point directly.
#pragma once

#include "integrators/integrator.h"

namespace tilecast {

struct DirectLight {
  Rgb radiance{0.0};  // times |cos| at the light and distance, over the density: what arrives, divided by cos here
  Vec3 direction;     // world space, unit length
  double pdf = 0.0;   // per solid angle; 0: from one direction, which no other strategy can find
  Ray shadow;         // ends at the light: at t = 1, or at infinity
  double distance = kInfinity;

  bool arrives() const { return max_component(radiance) > 0.0; }
};

// A sample of the chosen light, over the probability of the choice.
DirectLight sample_direct(const Scene& scene, const Surface& surface, const LightChoice& choice, Sampler& sampler);

// The densities per solid angle with which sample_direct() finds, from a place where the light is chosen with this
// probability, a point of it a `distance` away, seen under `cosine`; and the environment in a direction. 0: not at all.
double area_light_pdf(const AreaLight& light, double probability, const Vec3& from, double distance, double cosine);
double environment_pdf(const Lights& lights, double probability, const Vec3& direction);

// Of two strategies with these densities, the weight of the first (Veach's power heuristic). 0 stands for a strategy that
// cannot; a is greater than 0.
inline double power_heuristic(double a, double b) {
  const double ratio = b / a;
  return 1.0 / (1.0 + ratio * ratio);
}

// What comes from where a ray hits nothing.
inline Rgb background(const Scene& scene, const Vec3& direction) {
  if (built_with("environment") && scene.lights.environment) return scene.lights.environment->radiance(direction);
  return built_with("background") ? scene.background : Rgb(0.0);
}

}  // namespace tilecast
