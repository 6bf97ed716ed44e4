// Gate 12: nothing absolute anywhere. A scene scaled by a power of two gives the same hits, and t scaled exactly.
#include "stress/scenes.h"
#include "stress/stress.h"

namespace tilecast::stress {
namespace {

constexpr int kMost = 40;  // k = -40 .. 40

using ScaledScenes = std::vector<std::shared_ptr<const Scene>>;  // by k + kMost

template <class Make>
ScaledScenes scaled(Make&& make) {
  ScaledScenes out;
  for (int k = -kMost; k <= kMost; ++k) out.push_back(make(std::ldexp(1.0, k)));
  return out;
}

const ScaledScenes& meshes() {
  static const ScaledScenes all = scaled([](double s) {
    SceneBuilder builder;
    uint32_t ball = builder.add_mesh(icosphere(2).transformed(s, Vec3(0.3 * s)).build(), "auto");
    uint32_t cube = builder.add_mesh(gridded_cube(3).transformed(0.7 * s, Vec3(-0.4 * s)).build(), "auto");
    return scene_of(builder, {{ball, Affine{}}, {cube, Affine{}}});
  });
  return all;
}

// The affine map with its translation scaled: what holds objects of s times the size as before.
Affine moved(Affine map, double s) {
  map.offset *= s;
  return map;
}

const ScaledScenes& instances() {
  static const ScaledScenes all = scaled([](double s) {
    Random random(12);
    SceneBuilder builder;
    uint32_t ball = builder.add_mesh(icosphere(1).transformed(0.4 * s, Vec3(0)).build(), "auto");
    uint32_t sphere = builder.add_solid(Sphere{0.4 * s}), rectangle = builder.add_rectangle(s, 0.5 * s);
    std::vector<InstanceSource> members, top;
    for (uint32_t object : {ball, sphere, rectangle})
      for (int i = 0; i < 3; ++i) members.push_back({object, moved(random_affine(random), s)});
    uint32_t group = builder.add_group(members, "auto");
    for (int i = 0; i < 4; ++i) top.push_back({group, moved(random_affine(random), s)});
    return scene_of(builder, top);
  });
  return all;
}

const ScaledScenes& csg() {
  static const ScaledScenes all = scaled([](double s) {
    Random random(13);
    SceneBuilder builder;
    uint32_t operands[] = {builder.add_solid(Sphere{0.9 * s}), builder.add_solid(Block{Vec3(-0.6 * s), Vec3(0.6 * s)}),
                           builder.add_solid(Cylinder{0.4 * s, 2.0 * s}),
                           builder.add_mesh(gridded_cube(2).transformed(0.5 * s, Vec3(0)).build(), "auto")};
    uint32_t tree = operands[0];
    for (int i = 0; i < 12; ++i)
      tree = builder.add_csg(static_cast<CsgOperation>(i % 3), {{tree, moved(random_affine(random), 0.1 * s)},
                                                                {operands[i % 4], moved(random_affine(random), s)}});
    uint32_t flush = builder.add_csg(CsgOperation::Difference, {{operands[1], Affine{}}, {operands[1], translate(Vec3(0.6 * s, 0, 0))}});
    return scene_of(builder, {{tree, Affine{}}, {flush, moved(random_affine(random), s)}});
  });
  return all;
}

// Cases are a ray and a scale each; nine scales in turn share a ray.
double changed(const ScaledScenes& scenes, uint64_t first, uint64_t count) {
  thread_local std::vector<Crossing> of_a, of_b;
  Ray ray;
  Hit hit;
  return sum_over_rows(first, count, 9, [&](Random& random, uint64_t number) {
    ray = random_ray(random, number % 3 ? 4.0 : 0.5);
    hit = closest(*scenes[kMost], ray);
    crossings(*scenes[kMost], ray, of_a);
  }, [&](Random& random, uint64_t i) {
    int k = static_cast<int>(i % (2 * kMost + 1)) - kMost;
    double s = std::ldexp(1.0, k);
    bool longer = random() & 1;  // the ray's length may grow along, or its t
    Ray far{ray.origin * s, ray.direction * (longer ? s : 1.0)};
    double t_scale = longer ? 1.0 : s;
    auto same = [&](const Hit& x, const Hit& y) {
      return x.primitive == y.primitive && x.t * t_scale == y.t && x.u == y.u && x.v == y.v && x.entering == y.entering;
    };
    crossings(*scenes[kMost + k], far, of_b);
    return !same(hit, closest(*scenes[kMost + k], far)) ||
           !std::equal(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(), same);
  });
}

void add(std::vector<Case>& out, const char* name, const ScaledScenes& (*scenes)()) {
  out.push_back({name, 12, "rays whose hits change with the scale", 0, Combine::Sum, 1'000'000, 1'000'000'000,
                 [scenes](uint64_t first, uint64_t count) { return changed(scenes(), first, count); }});
}

}  // namespace

void add_scaling(std::vector<Case>& out) {
  add(out, "scaled-meshes", meshes);
  add(out, "scaled-instances", instances);
  add(out, "scaled-csg", csg);
}

}  // namespace tilecast::stress
