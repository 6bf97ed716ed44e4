// Short ways to put scenes together.
#pragma once

#include <random>

#include "stress/meshes.h"
#include "scene/builder.h"
#include "scene/trace.h"

namespace tilecast::stress {

inline Affine translate(const Vec3& t) { return {glm::dmat3(1.0), t}; }
inline Affine scale(const Vec3& s) {
  Affine a;
  for (int i = 0; i < 3; ++i) a.linear[i][i] = s[i];
  return a;
}
inline Affine rotate(double angle, const Vec3& axis) {
  double s = std::sin(angle), c = std::cos(angle);
  Affine out;
  for (int i = 0; i < 3; ++i) {
    Vec3 e(0.0);
    e[i] = 1.0;
    out.linear[i] = e * c + glm::cross(axis, e) * s + axis * (glm::dot(axis, e) * (1.0 - c));
  }
  return out;
}
inline Affine random_affine(std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(-1, 1), size(0.3, 1.5);
  Vec3 s{size(random), size(random), size(random)};
  if (random() & 1) s.x = -s.x;
  return translate({unit(random), unit(random), unit(random)}) * rotate(3.0 * unit(random), random_direction(random)) * scale(s);
}

inline std::shared_ptr<const Scene> scene_of(SceneBuilder& builder, const std::vector<InstanceSource>& instances,
                                             const AcceleratorChoice& accelerator = "auto", SceneBuilder::Options options = {}) {
  return builder.build(builder.add_group(instances, accelerator), options);
}

inline Ray random_ray(std::mt19937_64& random, double radius) {
  Vec3 origin = radius * random_direction(random);
  std::uniform_real_distribution<double> unit(-1, 1);
  return {origin, Vec3{unit(random), unit(random), unit(random)} - origin};
}

}  // namespace tilecast::stress
