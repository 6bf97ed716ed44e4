// What eight get at once is what each gets alone, to the last bit.
#include <gtest/gtest.h>

#include "base/sampler_lanes.h"
#include "geometry/sure_crossing.h"
#include "geometry/sure_lanes.h"
#include "optics/fresnel.h"
#include "optics/fresnel_lanes.h"
#include "render/chunk.h"
#include "scene/surface_lanes.h"
#include "shading/basis.h"
#include "shading/basis_lanes.h"
#include "stress/scenes.h"
#include "stress/shapes.h"

namespace tilecast {
namespace {

using namespace stress;

uint64_t bits_of(double x) { return std::bit_cast<uint64_t>(x); }
#define EXPECT_SAME(a, b) ASSERT_EQ(bits_of(a), bits_of(b))
#define EXPECT_SAME_VECTOR(a, b) \
  for (int axis = 0; axis < 3; ++axis) EXPECT_SAME((a)[axis], (b)[axis])

TEST(Lanes, SamplersDrawTheSameNumbers) {
  Random random(1);
  for (int i = 0; i < 100000; ++i) {
    Uint8Lanes x, y, sample;
    for (int lane = 0; lane < kLanes; ++lane) x[lane] = random(), y[lane] = random() % 5000, sample[lane] = random() % 64;
    const uint32_t seed = random();
    const Sampling sampling = i % 2 ? Sampling::Sobol : Sampling::Independent;
    const SamplerLanes<Uint8Lanes> lanes(x, y, sample, seed, sampling);
    Double8 u, v;
    lanes.next2(0, u, v);
    for (int lane = 0; lane < kLanes; ++lane) {
      Sampler alone(x[lane], y[lane], sample[lane], seed, sampling);
      const Vec2 expected = alone.next2();
      EXPECT_SAME(u[lane], expected.x);
      EXPECT_SAME(v[lane], expected.y);
      Sampler after = lanes.lane(lane, 1);
      EXPECT_SAME(after.next1(), alone.next1());
    }
  }
}

TEST(Lanes, PinholesSendTheSameRays) {
  Random random(2);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 1000; ++i) {
    const Camera camera(Vec3(unit(random), unit(random), unit(random)), Vec3(0.1, 5.0, 0.2), random_direction(random), 50.0, 640, 480);
    Double8 x, y;
    for (int lane = 0; lane < kLanes; ++lane) x.set(lane, 640 * unit(random)), y.set(lane, 480 * unit(random));
    const Vec3Lanes directions = camera.pinhole_directions(x, y);
    for (int lane = 0; lane < kLanes; ++lane) EXPECT_SAME_VECTOR(directions[lane], camera.ray(x[lane], y[lane]).direction);
  }
}

TEST(Lanes, FresnelAndBasesAreTheSame) {
  Random random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 200000; ++i) {
    Double8 c, eta;
    Vec3Lanes normal, v(random_direction(random));
    for (int lane = 0; lane < kLanes; ++lane) {
      c.set(lane, random() % 16 ? unit(random) : std::array{0.0, 1.0, 1e-12, 1 - 0x1p-53}[random() % 4]);
      eta.set(lane, random() % 8 ? std::exp(2 * unit(random) - 1) : std::array{1.0, 1.5, 1 / 1.5, 1 + 1e-12}[random() % 4]);
      normal.set(lane, random() % 8 ? random_direction(random) : Vec3(0.0, 0.0, random() % 2 ? 1.0 : -1.0));
    }
    const FresnelLanes<Double8> lanes = fresnel_dielectric(c, eta);
    const BasisLanes basis(normal);
    const Vec3Lanes local = basis.to_local(v), world = basis.to_world(v);
    for (int lane = 0; lane < kLanes; ++lane) {
      const Fresnel alone = fresnel_dielectric(c[lane], eta[lane]);
      EXPECT_SAME(lanes.reflectance[lane], alone.reflectance);
      EXPECT_SAME(lanes.cos_transmitted[lane], alone.cos_transmitted);
      ASSERT_EQ((bits(lanes.total) >> lane & 1) != 0, alone.total);
      const Basis one(normal[lane]);
      EXPECT_SAME_VECTOR(local[lane], one.to_local(v[lane]));
      EXPECT_SAME_VECTOR(world[lane], one.to_world(v[lane]));
    }
  }
}

TEST(Lanes, SureCrossingsAreTheSame) {
  Random random(4);
  std::uniform_real_distribution<double> unit(-1, 1);
  const Solid solids[] = {Sphere{0.8}, Sphere{3e-7}, Block{Vec3(-0.7, -0.2, -0.9), Vec3(0.3, 1.0, 0.1)}, Cylinder{0.5, 1.4},
                          Cylinder{1e-6, 3.0}};
  for (int i = 0; i < 100000; ++i) {
    const Solid& solid = solids[i % std::size(solids)];
    LineLanes lines;
    for (int lane = 0; lane < kLanes; ++lane) {
      Ray ray = random_ray(random, random() % 2 ? 3.0 : 0.4);
      if (random() % 8 == 0) ray.direction[random() % 3] = 0.0;
      if (random() % 8 == 0) ray.direction = Vec3(0, random() % 2 ? 1 : -1, 0);
      if (random() % 8 == 0) ray.direction *= std::exp2(40 * unit(random));
      if (random() % 16 == 0) ray.origin -= 1e6 * ray.direction;
      if (random() % 16 == 0) ray.origin = project(solid, 0, ray.origin);
      for (int k = 0; k < 3; ++k) lines.origin[k].set(lane, ray.origin[k]), lines.direction[k].set(lane, ray.direction[k]);
    }
    for (int number = 0; number < 2; ++number) {
      Double8 t;
      int32_t face[kLanes];
      const uint32_t found = sure_crossings(solid, lines, number, t, face);
      const SurelyAhead ahead = sure_crossings_ahead(solid, lines, number);
      for (int lane = 0; lane < kLanes; ++lane) {
        SolidCrossing alone;
        const bool has = sure_crossing(solid, lines.line(lane), number, alone);
        ASSERT_EQ((found >> lane & 1) != 0, has);
        if (has) {
          EXPECT_SAME(t[lane], alone.t);
          ASSERT_EQ(face[lane], alone.face);
        }
        const std::optional<bool> one = sure_crossing_ahead(solid, lines.line(lane), number);
        ASSERT_EQ((ahead.yes >> lane & 1) != 0, one == true);
        ASSERT_EQ((ahead.no >> lane & 1) != 0, one == false);
      }
    }
  }
}

// Parts of all that has lanes, and some that has none, in groups that are moved or turned.
std::shared_ptr<const Scene> parts(Random& random, const std::vector<Material>& materials, SceneBuilder::Options options,
                                   const std::vector<PointLight>& lights, bool sun = false, bool sky = false) {
  SceneBuilder builder;
  std::vector<int> numbers;
  const int checker = builder.add_texture(Checker{Rgb(0.9), Rgb(0.2), 0.13});
  for (Material material : materials) {
    if (material.texture == 0) material.texture = checker;
    numbers.push_back(builder.add_material(material));
  }
  auto any = [&] { return numbers[random() % numbers.size()]; };
  const uint32_t block = builder.add_solid(Block{Vec3(-0.7), Vec3(0.7)}), ball = builder.add_solid(Sphere{0.9}),
                 drill = builder.add_solid(Cylinder{0.4, 3.0}), ring = builder.add_solid(Torus{0.6, 0.2}),
                 square = builder.add_flat(Rectangle{1.5, 1.0}), disk = builder.add_flat(Disk{0.6});
  const uint32_t part = builder.add_csg(CsgOperation::Difference,
                                        {{builder.add_csg(CsgOperation::Intersection, {{block, Affine{}}, {ball, Affine{}, any()}}), Affine{}},
                                         {drill, Affine{}}, {drill, rotate(kPi / 2, Vec3(1, 0, 0)), any()}});
  std::vector<InstanceSource> inner, outer;
  for (uint32_t object : {part, part, ball, drill, ring, square, disk, block})
    inner.push_back({object, random() % 2 ? translate(2.0 * random_direction(random)) : random_affine(random), any()});
  const uint32_t group = builder.add_group(inner, "auto");
  outer.push_back({group, random() % 2 ? Affine{} : random_affine(random)});
  outer.push_back({group, translate({4.0, 0.0, 0.5})});
  for (int i = 0; i < 12; ++i) outer.push_back({part, translate(4.0 * random_direction(random)), any()});
  outer.push_back({builder.add_rectangle(40.0, 40.0), translate({0.0, -2.0, 0.0}), any()});
  for (const PointLight& light : lights) builder.add_point_light(light);
  if (sun) builder.add_directional_light({glm::normalize(Vec3(-1, -2, -0.5)), Rgb(0.4)});
  builder.set_background({0.2, 0.3, 0.4});
  if (sky) builder.set_environment(Environment({Vec3f(0.2f), Vec3f(0.5f), Vec3f(0.1f), Vec3f(0.4f)}, 2, 2, 30.0));
  builder.set_camera(Camera(Vec3(5.0, 4.0, 7.0), Vec3(0.0), Vec3(0, 1, 0), 45.0, 64, 48));
  return scene_of(builder, outer, "auto", options);
}

TEST(Lanes, SurfacesAreTheSame) {
  Random random(5);
  for (int scenes = 0; scenes < 20; ++scenes) {
    auto scene = parts(random, {Material{}}, {}, {});
    Ways ways(*scene);
    for (int i = 0; i < 3000; ++i) {
      const Ray middle = random_ray(random, 6.0);
      const Hit first = closest(*scene, middle);
      if (!first.found()) continue;
      Vec3Lanes origin, direction;
      Double8 t;
      std::vector<Ray> rays;
      std::vector<Hit> hits;
      for (int tries = 0; rays.size() < kLanes && tries < 100; ++tries) {  // on the same primitive from the same side
        const Ray ray{middle.origin, middle.direction + 0.05 * random_direction(random)};
        const Hit hit = closest(*scene, ray);
        if (hit.primitive == first.primitive && hit.entering == first.entering) rays.push_back(ray), hits.push_back(hit);
      }
      if (rays.size() < kLanes) continue;
      for (int lane = 0; lane < kLanes; ++lane)
        origin.set(lane, rays[lane].origin), direction.set(lane, rays[lane].direction), t.set(lane, hits[lane].t);
      const Ways::Way& way = ways.to(first.primitive);
      SurfaceLanes surfaces;
      const bool in_lanes = has_lanes(*scene, way);
      if (in_lanes) surfaces = resolve(*scene, way, origin, direction, t, first.entering);
      for (int lane = 0; lane < kLanes; ++lane) {
        const Surface alone = resolve(*scene, rays[lane], hits[lane]), kept = ways.resolve(way, rays[lane], hits[lane]);
        EXPECT_SAME_VECTOR(kept.point, alone.point);
        EXPECT_SAME_VECTOR(kept.normal, alone.normal);
        EXPECT_SAME(kept.error, alone.error);
        ASSERT_EQ(kept.material, alone.material);
        if (!in_lanes || !(surfaces.known >> lane & 1)) continue;
        EXPECT_SAME_VECTOR(surfaces.point[lane], alone.point);
        EXPECT_SAME_VECTOR(surfaces.normal[lane], alone.normal);
        EXPECT_SAME(surfaces.error[lane], alone.error);
        EXPECT_SAME_VECTOR(surfaces.spawn(direction)[lane], alone.spawn(direction[lane]));
      }
    }
  }
}

// A chunk of a tile, whose rays go together, against pixels that are asked for alone.
TEST(Lanes, WhittedsImagesAreTheSame) {
  Material diffuse, checkered, glass, water, mirror, plastic, half, lamp, rough, tinted, metal, frosted, glow;
  checkered.texture = 0;
  glass.kind = water.kind = tinted.kind = MaterialKind::Dielectric;
  glass.absorption = Rgb(0.1, 0.3, 0.0);
  water.ior = 1.33, water.priority = 1;
  tinted.tint = Rgb(0.9, 0.5, 0.7);
  mirror.kind = MaterialKind::Mirror;
  plastic.kind = MaterialKind::Plastic;
  half.opacity = 0.4;
  lamp.emission = Rgb(0.3, 0.2, 0.1);
  rough.roughness = 0.5;
  metal.kind = MaterialKind::Conductor, metal.roughness = 0.3;
  frosted.kind = glow.kind = MaterialKind::Dielectric;
  frosted.roughness = 0.3, frosted.opacity = 0.7;
  glow.emission = Rgb(0.1, 0.3, 0.2), glow.absorption = Rgb(0.5);
  const std::vector<Material> sets[] = {{diffuse}, {diffuse, checkered, rough, mirror, plastic}, {glass, checkered},
                                        {glass, water, tinted, diffuse}, {half, diffuse, mirror}, {lamp, glass, half, checkered},
                                        {metal, diffuse, lamp}, {metal, frosted, glow, glass}};
  const PointLight one{Vec3(6.0, 9.0, 4.0), Rgb(400.0)}, two{Vec3(-3.0, 5.0, 8.0), Rgb(100.0, 50.0, 150.0)};
  Random random(6);
  for (int i = 0; i < 24; ++i) {
    SceneBuilder::Options options;
    options.integrator = Integrator::Whitted;
    options.max_depth = 1 + i % 7;
    std::vector<PointLight> lights{one};
    if (i % 2) lights.push_back(two);
    auto scene = parts(random, sets[i % std::size(sets)], options, i % 5 == 4 ? std::vector<PointLight>{} : lights, i % 3 == 0,
                       i % 16 > 13);
    const Tile tile{3, 5, 37, 26};
    const ChunkSums whole = render_chunk(*scene, tile, 2, 3);
    const size_t plane = size_t(tile.width) * tile.height * 3;
    RayCounts rays;
    Tracing tracing;
    for (int y = 0; y < tile.height; ++y)
      for (int x = 0; x < tile.width; ++x) {
        Rgb sums[2] = {Rgb(0.0), Rgb(0.0)};
        for (uint32_t sample = 2; sample < 5; ++sample) {
          Sampler sampler(tile.x + x, tile.y + y, sample, scene->seed, scene->sampling);
          const Vec2 at = sampler.next2();
          const Ray ray = scene->camera.ray(tile.x + x + at.x, tile.y + y + at.y);
          sums[sample & 1] += trace_whitted(*scene, ray, media_at(*scene, ray.origin), sampler, tracing);
        }
        for (int half_of = 0; half_of < 2; ++half_of)
          for (int c = 0; c < 3; ++c)
            ASSERT_EQ(bits_of(whole.sums[half_of * plane + (size_t(y) * tile.width + x) * 3 + c]), bits_of(sums[half_of][c]))
                << "scene " << i << ", pixel " << x << ", " << y;
      }
    ASSERT_EQ(whole.rays.camera, tracing.counts.camera);
    ASSERT_EQ(whole.rays.bounce, tracing.counts.bounce);
    ASSERT_EQ(whole.rays.shadow, tracing.counts.shadow);
  }
}

}  // namespace
}  // namespace tilecast
