// Short ways to put scenes together.
#pragma once

#include <random>

#include "stress/meshes.h"
#include "scene/builder.h"
#include "scene/trace.h"

namespace tilecast::stress {

// make(kind) for every accelerator, brute force first.
template <class Make>
std::vector<std::shared_ptr<const Scene>> for_each_kind(Make&& make) {
  std::vector<std::shared_ptr<const Scene>> out;
  for (const std::string& kind : accelerator_kinds()) out.push_back(make(kind));
  return out;
}

// Whether two scenes give the same closest hit, occlusion and crossings, bit for bit.
inline bool same_hits(const Scene& a, const Scene& b, const Ray& ray) {
  auto same = [](const Hit& x, const Hit& y) {
    return x.t == y.t && x.primitive == y.primitive && x.u == y.u && x.v == y.v && x.entering == y.entering;
  };
  Hit hit = closest(a, ray);
  Ray bounded = ray;
  bounded.t_max = 1.0;
  thread_local std::vector<Crossing> of_a, of_b;
  crossings(a, ray, of_a);
  crossings(b, ray, of_b);
  return same(hit, closest(b, ray)) && occluded(a, bounded) == occluded(b, bounded) &&
         (hit.t <= 1.0) == occluded(b, bounded) && std::equal(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(), same);
}

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

// Meshes, solids and CSG in instances of instances, some of them twice at one place.
struct Crowd {
  uint64_t seed;
  int cells, levels;   // of the meshes: along the cube's edge; of the ball
  int copies, groups;  // of each object in a group; of the group
};
inline std::shared_ptr<const Scene> crowd(const Crowd& size, const AcceleratorChoice& accelerator) {
  std::mt19937_64 random(size.seed);
  SceneBuilder builder;
  uint32_t sphere = builder.add_solid(Sphere{0.4}), block = builder.add_solid(Block{Vec3(-0.3), Vec3(0.3)});
  uint32_t cylinder = builder.add_solid(Cylinder{0.2, 0.8}), rectangle = builder.add_rectangle(1.0, 0.7);
  uint32_t cube = builder.add_mesh(gridded_cube(size.cells).build(), accelerator);
  uint32_t ball = builder.add_mesh(icosphere(size.levels).transformed(0.5, Vec3(0.2)).build(), accelerator);
  uint32_t drilled = builder.add_csg(CsgOperation::Difference, {{block, Affine{}}, {cylinder, Affine{}}});
  std::vector<InstanceSource> members;
  for (uint32_t object : {sphere, block, cylinder, rectangle, cube, ball, drilled})
    for (int i = 0; i < size.copies; ++i) members.push_back({object, random_affine(random)});
  members.push_back(members.back());  // the same twice: only the order of primitives tells them apart
  members.push_back(members[4 * size.copies]);
  uint32_t group = builder.add_group(members, accelerator);
  std::vector<InstanceSource> top;
  for (int i = 0; i < size.groups; ++i) top.push_back({group, random_affine(random)});
  top.push_back({group, top[1].transform});
  top.push_back({cube, Affine{}});
  top.push_back({cube, Affine{}});
  return scene_of(builder, top, accelerator);
}

inline Ray random_ray(std::mt19937_64& random, double radius) {
  Vec3 origin = radius * random_direction(random);
  std::uniform_real_distribution<double> unit(-1, 1);
  return {origin, Vec3{unit(random), unit(random), unit(random)} - origin};
}

}  // namespace tilecast::stress
