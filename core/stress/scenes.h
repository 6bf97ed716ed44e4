// Short ways to put scenes together.
#pragma once

#include "scene/builder.h"
#include "scene/trace.h"
#include "stress/meshes.h"
#include "stress/stress.h"

namespace tilecast::stress {

// All that a scene can be asked about a ray: the closest hit, whether something lies at t <= 1, the line's crossings.
struct Answers {
  Hit hit;
  bool blocked = false;
  std::vector<Crossing> crossings;

  void ask(const Scene& scene, const Ray& ray) {
    Ray bounded = ray;
    bounded.t_max = 1.0;
    hit = closest(scene, ray);
    blocked = occluded(scene, bounded);
    tilecast::crossings(scene, ray, crossings);
  }
  bool consistent() const { return blocked == (hit.t <= 1.0); }
  // Bit for bit.
  bool operator==(const Answers& other) const {
    auto same = [](const Hit& x, const Hit& y) {
      return x.t == y.t && x.primitive == y.primitive && x.u == y.u && x.v == y.v && x.entering == y.entering;
    };
    return same(hit, other.hit) && blocked == other.blocked &&
           std::equal(crossings.begin(), crossings.end(), other.crossings.begin(), other.crossings.end(), same);
  }
};

// Scenes alike but for their accelerators, brute force first.
using Scenes = std::vector<std::shared_ptr<const Scene>>;
template <class Make>
Scenes for_each_kind(Make&& make) {
  Scenes out;
  for (const std::string& kind : accelerator_kinds()) out.push_back(make(kind));
  return out;
}

// A case's `run`: of cases that are a ray and an accelerator each, those whose answers are not those of brute force, which
// is asked once for each ray, aim(random, its number). scenes(): made at the first call.
template <class Aim>
auto against_brute_force(const Scenes& (*scenes)(), Aim aim) {
  return [=](uint64_t first, uint64_t count) {
    const Scenes& all = scenes();
    const uint64_t others = all.size() - 1;
    thread_local Answers expected, found;
    Ray ray;
    return sum_over_rows(first, count, others, [&](Random& random, uint64_t number) {
      ray = aim(random, number);
      expected.ask(*all[0], ray);
    }, [&](Random&, uint64_t i) {
      found.ask(*all[1 + i % others], ray);
      return !(expected.consistent() && found == expected);
    });
  };
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
inline Affine random_affine(Random& random) {
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
  Random random(size.seed);
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

inline Ray random_ray(Random& random, double radius) {
  Vec3 origin = radius * random_direction(random);
  std::uniform_real_distribution<double> unit(-1, 1);
  return {origin, Vec3{unit(random), unit(random), unit(random)} - origin};
}

}  // namespace tilecast::stress
