// Dielectrics inside each other and overlapping: what light loses on its way follows the medium that counts. Which one
// that is, at every crossing, is gate 27 of the hazards (core/stress/dielectrics.cpp).
#include <gtest/gtest.h>

#include "render/chunk.h"
#include "stress/scenes.h"

namespace tilecast {
namespace {

using namespace stress;

struct Layer {
  double first, last;  // along z
  double absorption;
  int priority;
};

// Slabs of index 1 before a background of radiance 1, looked at along -z from `start`.
Rgb through(const std::vector<Layer>& layers, double start, Integrator integrator) {
  SceneBuilder builder;
  std::vector<InstanceSource> placed;
  for (const Layer& layer : layers) {
    Material medium{.kind = MaterialKind::Dielectric, .ior = 1.0, .absorption = Rgb(layer.absorption, 0.0, 2.0 * layer.absorption),
                    .priority = layer.priority};
    double half = 3.0 - 0.1 * placed.size();
    placed.push_back({builder.add_solid(Block{Vec3(-half, -half, layer.first), Vec3(half, half, layer.last)}), Affine{},
                      builder.add_material(medium)});
  }
  builder.set_background(Rgb(1.0));
  builder.set_camera(Camera(Vec3(0, 0, start), Vec3(0, 0, -99), Vec3(0, 1, 0), 0.001, 1, 1));
  auto scene = scene_of(builder, placed, "auto", {.integrator = integrator, .max_depth = 20});
  ChunkSums chunk = render_chunk(*scene, {0, 0, 1, 1}, 0, 2);
  return 0.5 * Rgb(chunk.sums[0] + chunk.sums[3], chunk.sums[1] + chunk.sums[4], chunk.sums[2] + chunk.sums[5]);
}

TEST(Media, AbsorbAsTheOneThatCounts) {
  const std::vector<Layer> overlapping{{-4, 1, 0.3, 2}, {-2, 3, 0.7, 5}, {-6, 2, 0.2, 1}, {-1, 0, 1.1, 9}};
  auto expected = [&](double start) {  // the depth along the line, by the layer that counts in each stretch between ends
    double depth = 0.0;
    std::vector<double> ends{start};
    for (const Layer& layer : overlapping)
      for (double end : {layer.first, layer.last})
        if (end < start) ends.push_back(end);
    std::sort(ends.begin(), ends.end());
    for (size_t i = 1; i < ends.size(); ++i) {
      double z = 0.5 * (ends[i - 1] + ends[i]);
      const Layer* best = nullptr;
      for (const Layer& layer : overlapping)
        if (layer.first < z && z < layer.last && (!best || layer.priority > best->priority)) best = &layer;
      if (best) depth += best->absorption * (ends[i] - ends[i - 1]);
    }
    return depth;
  };
  for (Integrator integrator : {Integrator::Path, Integrator::Whitted})
    for (double start : {5.0, 2.5, 1.5, 0.5, -0.5, -1.5, -3.0, -5.0, -7.0}) {
      Rgb value = through(overlapping, start, integrator);
      EXPECT_NEAR(value.x, std::exp(-expected(start)), 1e-9) << start;
      EXPECT_NEAR(value.y, 1.0, 1e-9) << start;
      EXPECT_NEAR(value.z, std::exp(-2.0 * expected(start)), 1e-9) << start;
    }
}

TEST(Media, OfEqualPriorityCountTheInnermost) {
  const std::vector<Layer> nested{{-4, 4, 0.1, 0}, {-3, 3, 0.5, 0}, {-1, 1, 0.9, 0}};
  for (Integrator integrator : {Integrator::Path, Integrator::Whitted}) {
    EXPECT_NEAR(through(nested, 9.0, integrator).x, std::exp(-(0.1 * 2 + 0.5 * 4 + 0.9 * 2)), 1e-9);
    EXPECT_NEAR(through(nested, 0.0, integrator).x, std::exp(-(0.1 * 1 + 0.5 * 2 + 0.9 * 1)), 1e-9);
  }
}

// One material takes one place however often it is entered in a row, and yet counts as if each time were kept.
TEST(Media, AreAsAListOfAllThatWereEntered) {
  const Material materials[] = {{.ior = 1.1, .refracts = true}, {.ior = 1.2, .refracts = true},
                                {.ior = 1.3, .priority = 1, .refracts = true}, {.ior = 1.4, .priority = -1, .refracts = true}};
  Random random(3);
  for (int tries = 0; tries < 2000; ++tries) {
    Media media;
    std::vector<const Material*> list;
    for (int step = 0; step < 60; ++step) {
      const Material& material = materials[random() % 4];
      const bool entering = list.size() < 16 && random() % 2;
      const Material* before = list.empty() ? nullptr : list.back();
      auto after = list;
      if (entering) {
        auto at = std::find_if(after.begin(), after.end(), [&](auto* m) { return m->priority > material.priority; });
        after.insert(at, &material);
      } else if (auto last = std::find(after.rbegin(), after.rend(), &material); last != after.rend()) {
        after.erase(std::next(last).base());
      } else {
        continue;
      }
      const Material* behind = after.empty() ? nullptr : after.back();
      const Boundary boundary = media.at(material, entering);
      ASSERT_EQ(boundary.real, before != behind);
      if (boundary.real) {
        ASSERT_EQ(boundary.eta, (behind ? behind->ior : 1.0) / (before ? before->ior : 1.0));
      }
      media.cross(material, entering);
      list = std::move(after);
      ASSERT_EQ(media.current(), behind);
    }
  }
}

// A lamp and a diffuse ball in a medium, with a medium between them that does not count there: its surfaces must not
// stop shadow rays, as they do not stop paths.
TEST(Media, HiddenSurfacesDoNotStopShadowRays) {
  auto build = [](bool next_event, bool hidden) {
    SceneBuilder builder;
    builder.set_camera(Camera(Vec3(0, 1, 3), Vec3(0), Vec3(0, 1, 0), 10, 8, 8));
    int lamp = builder.add_material({.emission = Rgb(5.0)}), white = builder.add_material({.reflectance = Rgb(0.5)});
    int water = builder.add_material({.kind = MaterialKind::Dielectric, .ior = 1.33, .absorption = Rgb(0.2), .priority = 1});
    int glass = builder.add_material({.kind = MaterialKind::Dielectric, .ior = 1.6, .absorption = Rgb(9.0)});
    uint32_t block = builder.add_solid(Block{Vec3(-5), Vec3(5)}), floor = builder.add_rectangle(2, 2);
    std::vector<InstanceSource> list{{block, Affine{}, water}, {floor, Affine{}, white},
                                     {floor, translate(Vec3(0, 2, 0)) * rotate(kPi, Vec3(1, 0, 0)), lamp}};
    if (hidden) list.push_back({builder.add_solid(Block{Vec3(-4, 0.5, -4), Vec3(4, 0.75, 4)}), Affine{}, glass});
    return scene_of(builder, list, "auto", {.max_depth = 2, .next_event = next_event});
  };
  auto mean = [](const Scene& scene, uint32_t samples) {
    ChunkSums chunk = render_chunk(scene, {0, 0, 8, 8}, 0, samples);
    double sum = 0.0;
    for (double value : chunk.sums) sum += value;
    return sum / (192.0 * samples);
  };
  double open = mean(*build(true, false), 256);
  EXPECT_GT(open, 0.1);
  EXPECT_NEAR(mean(*build(true, true), 256), open, 1e-9);
  EXPECT_NEAR(mean(*build(false, true), 1024), open, 0.02 * open);
}

// Sheets that a part of the light misses, one behind the other, and what they cover of a lamp.
TEST(Opacity, LetsItsShareThrough) {
  for (Integrator integrator : {Integrator::Path, Integrator::Whitted}) {
    SceneBuilder builder;
    builder.set_camera(Camera(Vec3(0, 0, 5), Vec3(0), Vec3(0, 1, 0), 0.001, 1, 1));
    builder.set_background(Rgb(1.0));
    int black = builder.add_material({.reflectance = Rgb(0.0), .opacity = 0.25});
    uint32_t ball = builder.add_solid(Sphere{1.0});
    auto scene = scene_of(builder, {{ball, Affine{}, black}}, "auto", {.integrator = integrator});
    const uint32_t samples = 1 << 16;
    ChunkSums chunk = render_chunk(*scene, {0, 0, 1, 1}, 0, samples);
    EXPECT_NEAR((chunk.sums[0] + chunk.sums[3]) / samples, 0.75 * 0.75, 5 * 0.5 / std::sqrt(samples));
  }
  for (Integrator integrator : {Integrator::Path, Integrator::Whitted}) {
    SceneBuilder builder;
    builder.set_camera(Camera(Vec3(0, 1e-3, 0.1), Vec3(0, 0, 0), Vec3(0, 1, 0), 0.001, 1, 1));
    int white = builder.add_material({.reflectance = Rgb(0.5)}), net = builder.add_material({.opacity = 0.4});
    builder.add_point_light({Vec3(0, 2, 0), Rgb(12.0)});
    uint32_t sheet = builder.add_rectangle(1, 1);
    auto scene = scene_of(builder, {{sheet, Affine{}, white}, {sheet, translate(Vec3(0, 1, 0)), net}}, "auto",
                          {.integrator = integrator, .max_depth = 2});
    ChunkSums chunk = render_chunk(*scene, {0, 0, 1, 1}, 0, 2);
    EXPECT_NEAR(0.5 * (chunk.sums[0] + chunk.sums[3]), 0.6 * 0.5 / kPi * 12.0 / 4.0, 1e-4);
  }
}

// In uniform light a ball of glass of which half the light takes no notice is as bright as the light.
TEST(Opacity, OfGlassKeepsTheFurnaceWhite) {
  SceneBuilder builder;
  builder.set_camera(Camera(Vec3(0, 0, 4), Vec3(0), Vec3(0, 1, 0), 40, 16, 16));
  builder.set_background(Rgb(1.0));
  int glass = builder.add_material({.kind = MaterialKind::Dielectric, .ior = 1.7, .opacity = 0.5});
  auto scene = scene_of(builder, {{builder.add_solid(Sphere{1.0}), Affine{}, glass}}, "auto", {.max_depth = 1000});
  for (double value : render_chunk(*scene, {0, 0, 16, 16}, 0, 2).sums) EXPECT_NEAR(value, 1.0, 1e-12);
}

}  // namespace
}  // namespace tilecast
