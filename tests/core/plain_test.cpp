// Paths four at a time against paths one by one: the same bits. Lamps that are looked for apart: the same image.
#include <gtest/gtest.h>

#include "estimates.h"
#include "integrators/plain_paths.h"
#include "stress/scenes.h"

namespace tilecast {
namespace {

using namespace stress;

struct Room {
  bool lamp = true, high_lamp = true, background = false, tilted = false, glowing_box = false;
  PixelFilter::Kind filter = PixelFilter::Kind::Box;
  Camera camera{Vec3(0, 0, 3.9), Vec3(0), Vec3(0, 1, 0), 39.3, 32, 32};
};

// After the Cornell box: two boxes on the floor of five walls, all in several colours.
std::shared_ptr<const Scene> build(const Room& room, const SceneBuilder::Options& options) {
  SceneBuilder builder;
  builder.set_camera(room.camera);
  builder.set_filter(room.filter);
  const int white = builder.add_material({.reflectance = Rgb(0.9, 0.7, 0.65)});
  const int red = builder.add_material({.reflectance = Rgb(0.6, 0.05, 0.04)});
  const int lamp = builder.add_material({.reflectance = Rgb(0.9), .emission = Rgb(18, 14, 7)});
  const int black = builder.add_material({.reflectance = Rgb(0.0)});
  const uint32_t wall = builder.add_rectangle(2, 2), square = builder.add_rectangle(0.46, 0.38);
  const uint32_t cube = builder.add_solid(Block{Vec3(-1.0), Vec3(1.0)});
  const uint32_t flat = builder.add_solid(Block{Vec3(-0.3, -0.1, -0.2), Vec3(0.2, 0.1, 0.5)});
  std::vector<InstanceSource> list{
      {wall, translate(Vec3(0, -1, 0)), white},
      {wall, translate(Vec3(0, 1, 0)) * rotate(kPi, Vec3(1, 0, 0)), white},
      {wall, translate(Vec3(0, 0, -1)) * rotate(0.5 * kPi, Vec3(1, 0, 0)), kInherit},
      {wall, translate(Vec3(1, 0, 0)) * rotate(0.5 * kPi, Vec3(0, 0, 1)), red},
      {wall, translate(Vec3(-1, 0, 0)) * rotate(-0.5 * kPi, Vec3(0, 0, 1)), red},
      {cube, translate(Vec3(0.3, -0.7, 0.4)) * rotate(0.3, Vec3(0, 1, 0)) * scale(Vec3(0.3)), white},
      {cube, translate(Vec3(-0.3, -0.4, -0.3)) * rotate(-0.3, Vec3(0, 1, 0)) * scale(Vec3(-0.3, 0.6, 0.3)),
       room.glowing_box ? lamp : white},
      {flat, translate(Vec3(0.4, 0.3, -0.2)), white},
      {flat, translate(Vec3(-0.6, 0.2, 0.5)) * rotate(1.0, glm::normalize(Vec3(1, 2, 3))), black}};
  const Vec3 place = room.high_lamp ? Vec3(0, 0.99, 0) : Vec3(0, 0.5, 0.5);
  if (room.lamp) list.push_back({square, translate(place) * rotate(kPi, Vec3(1, 0, 0)), lamp});
  const Affine away = rotate(0.7, glm::normalize(Vec3(1, 1, 0))) * translate(Vec3(1e3, -2, 5));
  if (room.tilted)
    for (InstanceSource& source : list) source.transform = away * source.transform;
  if (room.background) builder.set_background(Rgb(0.3, 0.2, 0.5));
  return scene_of(builder, list, "auto", options);
}

// Balls, turned, squeezed and only moved, boxes and a wall, that mirror or are of glass, among chalk.
struct Glazed {
  bool apart = true;  // no piece of glass in another, or in the lamp's way only
  Rgb absorption{0.0}, tint{1.0};
  bool background = true;
  Camera camera{Vec3(0, 0, 3.9), Vec3(0), Vec3(0, 1, 0), 39.3, 32, 32};
};

std::shared_ptr<const Scene> glazed(const Glazed& room, const SceneBuilder::Options& options) {
  SceneBuilder builder;
  builder.set_camera(room.camera);
  const int white = builder.add_material({.reflectance = Rgb(0.9, 0.7, 0.65)});
  const int mirror = builder.add_material({.kind = MaterialKind::Mirror, .reflectance = Rgb(0.9, 0.8, 1.0)});
  const int glass = builder.add_material(
      {.kind = MaterialKind::Dielectric, .ior = 1.6, .absorption = room.absorption, .tint = room.tint});
  const int lamp = builder.add_material({.reflectance = Rgb(0.9), .emission = Rgb(18, 14, 7)});
  const uint32_t wall = builder.add_rectangle(2, 2), square = builder.add_rectangle(0.46, 0.38);
  const uint32_t cube = builder.add_solid(Block{Vec3(-1.0), Vec3(1.0)}), ball = builder.add_solid(Sphere{0.3});
  std::vector<InstanceSource> list{
      {wall, translate(Vec3(0, -1, 0)), white},
      {wall, translate(Vec3(0, 1, 0)) * rotate(kPi, Vec3(1, 0, 0)), white},
      {wall, translate(Vec3(0, 0, -1)) * rotate(0.5 * kPi, Vec3(1, 0, 0)), mirror},
      {wall, translate(Vec3(1, 0, 0)) * rotate(0.5 * kPi, Vec3(0, 0, 1)), white},
      {square, translate(Vec3(0, 0.99, 0)) * rotate(kPi, Vec3(1, 0, 0)), lamp},
      {ball, translate(Vec3(0.5, -0.7, 0.5)), glass},
      {ball, translate(Vec3(-0.5, -0.6, 0.4)) * rotate(0.4, glm::normalize(Vec3(1, 2, 3))) * scale(Vec3(1.0, -1.3, 0.7)), glass},
      {cube, translate(Vec3(0.4, 0.2, -0.4)) * rotate(0.3, Vec3(0, 1, 0)) * scale(Vec3(0.2)), glass},
      {ball, translate(Vec3(-0.4, 0.3, -0.4)), mirror},
      {ball, Affine{}, white},
      {cube, translate(Vec3(-0.6, -0.85, -0.6)) * scale(Vec3(0.2, 0.15, 0.2)), mirror}};
  if (!room.apart) {
    list.push_back({ball, translate(Vec3(0.7, -0.7, 0.5)), glass});                        // partly in the first
    list.push_back({ball, translate(Vec3(0.4, -0.7, 0.5)) * scale(Vec3(0.3)), white});     // all in it
    list.push_back({ball, translate(Vec3(-0.5, -0.6, 0.4)) * scale(Vec3(0.4)), mirror});
  }
  if (room.background) builder.set_background(Rgb(0.3, 0.2, 0.5));
  return scene_of(builder, list, "auto", options);
}

void expect_same_bits(const Scene& scene, uint32_t first = 0, uint32_t count = 8, bool lit = true) {
  ASSERT_TRUE(PlainScene::of(scene));
  const Tile tile{3, 1, 29, 30};
  const ChunkSums many = render_chunk(scene, tile, first, count), one = render_chunk_one_by_one(scene, tile, first, count);
  size_t other = 0, at = 0;
  for (size_t i = 0; i < many.sums.size(); ++i)
    if (many.sums[i] != one.sums[i]) ++other, at = i;
  ASSERT_EQ(other, 0u) << "of " << one.sums.size() << ", the last " << many.sums[at] << " instead of " << one.sums[at];
  EXPECT_EQ(many.rays.camera, one.rays.camera);
  EXPECT_EQ(many.rays.bounce, one.rays.bounce);
  EXPECT_EQ(many.rays.shadow, one.rays.shadow);
  if (lit) EXPECT_GT(*std::max_element(many.sums.begin(), many.sums.end()), 0.0);
}

TEST(PlainPaths, HaveTheBitsOfPathsOneByOne) {
  expect_same_bits(*build({}, {}));
  expect_same_bits(*build({}, {}), 5, 3);
  expect_same_bits(*build({}, {}), 1, 1);
  expect_same_bits(*build({}, {.max_depth = 30, .seed = 7}));
  expect_same_bits(*build({}, {.max_depth = 1}));
  expect_same_bits(*build({}, {.integrator = Integrator::Direct}));
  expect_same_bits(*build({}, {.next_event = false}));
  expect_same_bits(*build({}, {.sampling = Sampling::Independent, .roulette = false}));
  expect_same_bits(*build({.high_lamp = false, .background = true}, {}));
  expect_same_bits(*build({.lamp = false, .background = true}, {}));
  expect_same_bits(*build({.background = true, .glowing_box = true}, {}));
  const Vec3 middle = rotate(0.7, glm::normalize(Vec3(1, 1, 0))).point(Vec3(1e3, -2, 5));
  const Camera there(middle + Vec3(1, 2, 4), middle, Vec3(0, 1, 0), 40, 32, 32);
  expect_same_bits(*build({.background = true, .tilted = true, .camera = there}, {}));
  expect_same_bits(*build({.filter = PixelFilter::Kind::Mitchell}, {}));
  const View view{Vec3(0.1, 0.2, 0.3), Vec3(0, 0, -1), Vec3(0, 1, 0), 32, 32};
  expect_same_bits(*build({.background = true, .camera = Camera::thin_lens(view, 50, 0.2, 3.0)}, {}));
  expect_same_bits(*build({.camera = Camera::panorama(view)}, {}));
}

TEST(PlainPaths, HaveTheBitsOfPathsOneByOneAmongGlassAndMirrors) {
  for (bool apart : {true, false}) {
    expect_same_bits(*glazed({.apart = apart}, {}), 0, 64);
    expect_same_bits(*glazed({.apart = apart}, {}), 5, 3);
    expect_same_bits(*glazed({.apart = apart, .background = false}, {.max_depth = 30, .seed = 7}));
    const Rgb absorption(0.0, 2.0, 0.3), tint(0.9, 1.0, 0.5);
    expect_same_bits(*glazed({.apart = apart, .absorption = absorption, .tint = tint}, {.max_depth = 20}), 0, 32);
    expect_same_bits(*glazed({.apart = apart}, {.max_depth = 1}));
    expect_same_bits(*glazed({.apart = apart}, {.integrator = Integrator::Direct}));
    expect_same_bits(*glazed({.apart = apart}, {.next_event = false}));
    expect_same_bits(*glazed({.apart = apart}, {.sampling = Sampling::Independent, .roulette = false}));
    // All around, through a lens, and where some rays start in glass.
    const View view{Vec3(0.05, 0.5, 0.02), Vec3(0, 0, -1), Vec3(0, 1, 0), 32, 32};
    expect_same_bits(*glazed({.apart = apart, .camera = Camera::panorama(view)}, {}));
    const View outside{Vec3(0.1, 0.2, 3.0), Vec3(0, 0, -1), Vec3(0, 1, 0), 32, 32};
    expect_same_bits(*glazed({.apart = apart, .camera = Camera::thin_lens(outside, 50, 0.2, 3.0)}, {}));
    const View in_glass{Vec3(0.5, -0.7, 0.5), Vec3(0, 0, -1), Vec3(0, 1, 0), 32, 32};
    expect_same_bits(*glazed({.apart = apart, .camera = Camera::panorama(in_glass)}, {}));
    expect_same_bits(*glazed({.apart = apart, .camera = Camera::orthographic(in_glass, 2.0)}, {}));
  }
  // Along the axes, through the middle of balls: coordinates are zeros of either sign.
  for (const Vec3& eye : {Vec3(0, 0, 5), Vec3(0, 0, -5), Vec3(5, 0, 0), Vec3(-5, 0, 0), Vec3(1e-9, 5, 0.0)})
    for (const Vec3& up : {Vec3(1e-2, 1, 1e-2), Vec3(1e-2, 0.3, -1), Vec3(1e-3, -1, 1e-3)})
      expect_same_bits(*glazed({.camera = Camera::orthographic({eye, Vec3(0), up, 33, 33}, 3.3)}, {}));
}

// Far and near, large and small: what a ball's chord goes through.
TEST(PlainPaths, MeetBallsAsPathsOneByOneDo) {
  Random random(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 300; ++i) {
    SceneBuilder builder;
    const int mirror = builder.add_material({.kind = MaterialKind::Mirror});
    const int glass = builder.add_material({.kind = MaterialKind::Dielectric});
    const double radius = std::exp2(60 * unit(random)), reach = radius * std::exp2(std::abs(20 * unit(random)));
    const Vec3 centre(reach * unit(random), reach * unit(random), reach * unit(random));
    const Affine turned = rotate(unit(random), random_direction(random)) * scale(Vec3(1.0, 1.0 + 0.5 * unit(random), 2.0));
    const Affine place = translate(centre) * (i % 2 ? turned : Affine{});
    builder.set_background(Rgb(0.3, 0.2, 0.5));
    const Vec3 eye = centre + 3 * radius * random_direction(random), target = centre + 0.3 * radius * random_direction(random);
    builder.set_camera({eye, target, Vec3(0.1, 1, 0.3), 40, 32, 32});
    const uint32_t ball = builder.add_solid(Sphere{radius});
    expect_same_bits(*scene_of(builder, {{ball, place, i % 3 ? glass : mirror},
                                         {ball, translate(Vec3(2.5 * radius, 0, 0)) * place, i % 4 ? mirror : glass}}), 0, 2, false);
  }
}

TEST(PlainPaths, HaveTheBitsOfPathsOneByOneWhereRaysLieInPlanes) {
  // Parallel rays along the axes: components of 0, in the planes of walls and faces.
  for (const Vec3& eye : {Vec3(0, 0, 5), Vec3(5, 0, 0), Vec3(0.0, 5, 1e-3)})
    expect_same_bits(*build({.background = true, .camera = Camera::orthographic({eye, Vec3(0), Vec3(0, 1, 1e-2), 32, 32}, 2.0)}, {}));
}

TEST(PlainPaths, AreForPlainScenesAlone) {
  auto with = [](const Material& material) {
    SceneBuilder builder;
    return scene_of(builder, {{builder.add_rectangle(1, 1), Affine{}, builder.add_material(material)}});
  };
  EXPECT_TRUE(PlainScene::of(*with({})));
  EXPECT_TRUE(PlainScene::of(*with({.kind = MaterialKind::Mirror})));
  EXPECT_TRUE(PlainScene::of(*with({.kind = MaterialKind::Dielectric})));
  EXPECT_FALSE(PlainScene::of(*with({.kind = MaterialKind::Dielectric, .abbe = 40})));
  EXPECT_FALSE(PlainScene::of(*with({.kind = MaterialKind::Dielectric, .roughness = 0.2})));
  EXPECT_FALSE(PlainScene::of(*with({.kind = MaterialKind::Dielectric, .emission = Rgb(1)})));
  EXPECT_FALSE(PlainScene::of(*with({.roughness = 0.5})));
  EXPECT_FALSE(PlainScene::of(*with({.opacity = 0.5})));
  SceneBuilder builder;
  EXPECT_FALSE(PlainScene::of(*scene_of(builder, {{builder.add_solid(Cylinder{}), Affine{}, builder.add_material({})}})));
  SceneBuilder two;
  const int thin = two.add_material({.kind = MaterialKind::Dielectric, .ior = 1.3});
  const int thick = two.add_material({.kind = MaterialKind::Dielectric});
  const uint32_t ball = two.add_solid(Sphere{1.0});
  EXPECT_FALSE(PlainScene::of(*scene_of(two, {{ball, Affine{}, thick}, {ball, translate(Vec3(3, 0, 0)), thin}})));
}

TEST(LanesOfSamplers, GiveTheNumbersOfEach) {
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    Uint4 index, key;
    std::vector<Sampler> samplers;
    for (int lane = 0; lane < 4; ++lane) {
      samplers.emplace_back(uint32_t(random()), uint32_t(random()), uint32_t(random()), uint32_t(random()));
      index[lane] = samplers[lane].index(), key[lane] = samplers[lane].key();
    }
    const SamplerLanes<Uint4> lanes(index, key);
    for (uint32_t dimension = 0; dimension < 6; ++dimension) {
      Double4 x, y{};
      if (dimension % 3 == 2) x = lanes.next1(dimension);
      else lanes.next2(dimension, x, y);
      for (int lane = 0; lane < 4; ++lane) {
        ASSERT_EQ(samplers[lane].dimension(), dimension);
        const Vec2 u = dimension % 3 == 2 ? Vec2(samplers[lane].next1(), 0.0) : samplers[lane].next2();
        ASSERT_EQ(u.x, x[lane]);
        ASSERT_EQ(u.y, y[lane]);
      }
    }
  }
}

TEST(DoubleLanes, HaveTheBitsOfPlainCode) {
  for (int i = 0; i <= 1 << 16; ++i) {
    const double u = i * 0x1p-16;
    double sine, cosine;
    sincos_2pi(u, sine, cosine);
    Double4 sines, cosines;
    sincos_2pi(all(u), sines, cosines);
    for (int lane = 0; lane < 4; ++lane) ASSERT_TRUE(sines[lane] == sine && cosines[lane] == cosine) << u;
  }
  for (uint32_t mask = 0; mask < 16; ++mask) {
    double kept[4];
    uint32_t numbers[4];
    keep(kept, Double4{1, 2, 3, 4}, mask);
    keep(numbers, Uint4{1, 2, 3, 4}, mask);
    int at = 0;
    for (int lane = 0; lane < 4; ++lane)
      if (mask >> lane & 1) {
        EXPECT_EQ(kept[at], lane + 1);
        EXPECT_EQ(numbers[at++], uint32_t(lane + 1));
      }
  }
  EXPECT_EQ(to_double(Uint4{0, 1, 0x80000000u, 0xffffffffu})[3], 4294967295.0);
}

// A lamp that is a part of a pixel: what the pixel shows is its radiance times the part, whose noise is far less than that
// of as many rays of the paths alone.
TEST(LampsInView, AreAsBrightAsTheyAreLarge) {
  for (bool glass : {false, true}) {  // whose surfaces want the other kernel, and stand in no pixel's way
    SceneBuilder builder;
    builder.set_camera(Camera::orthographic({Vec3(0, 0, 5), Vec3(0), Vec3(0, 1, 0), 64, 64}, 64.0));
    const int lamp = builder.add_material({.emission = Rgb(1.0)});
    const int clear = builder.add_material({.kind = MaterialKind::Dielectric});
    const Affine upright = translate(Vec3(0.2, 0.1, 0)) * rotate(0.5 * kPi, Vec3(1, 0, 0));
    std::vector<InstanceSource> list{{builder.add_rectangle(2.5, 1.3), upright, lamp}};
    if (glass) list.push_back({builder.add_solid(Sphere{1.0}), translate(Vec3(0, 0, -500)), clear});
    auto scene = scene_of(builder, list);
    const int n = 256;  // 8 times as many points: an edge's error falls by their power of 3/4
    const ChunkSums chunk = render_chunk(*scene, {0, 0, 64, 64}, 0, n);
    double sum = 0.0;
    for (size_t i = 0; i < chunk.sums.size(); i += 3) sum += chunk.sums[i];
    EXPECT_NEAR(sum / n, 2.5 * 1.3, 0.025);
    EXPECT_GT(chunk.rays.camera, 64 * 64 * n);
  }
}

// Of parallel rays some start inside of glass, where a lamp is not seen as from outside: whether a pixel looks for lamps apart must
// not hang on where the rays before it began.
TEST(LampsInView, DoNotDependOnTheTile) {
  SceneBuilder builder;
  builder.set_camera(Camera::orthographic({Vec3(0), Vec3(0, 0, -1), Vec3(0, 1, 0), 32, 32}, 32.0));
  const int lamp = builder.add_material({.emission = Rgb(1.0)});
  const int tinted = builder.add_material({.kind = MaterialKind::Dielectric, .absorption = Rgb(0.05)});
  const Affine upright = translate(Vec3(0.2, 0.1, -30)) * rotate(0.5 * kPi, Vec3(1, 0, 0));
  auto scene = scene_of(builder, {{builder.add_rectangle(4.0, 5.0), upright, lamp},
                                  {builder.add_solid(Sphere{1.0}), Affine{}, tinted}});
  const int size = 32, part = 7;
  const ChunkSums whole = render_chunk(*scene, {0, 0, size, size}, 0, 8);
  for (int y = 0; y < size; y += part)
    for (int x = 0; x < size; x += part) {
      const Tile tile{x, y, std::min(part, size - x), std::min(part, size - y)};
      const ChunkSums chunk = render_chunk(*scene, tile, 0, 8);
      for (int half = 0; half < 2; ++half)
        for (int row = 0; row < tile.height; ++row)
          for (int i = 0; i < tile.width * 3; ++i)
            ASSERT_EQ(chunk.sums[(half * tile.height + row) * tile.width * 3 + i],
                      whole.sums[((half * size + y + row) * size + x) * 3 + i]);
    }
}

}  // namespace
}  // namespace tilecast
