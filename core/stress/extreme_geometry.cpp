// Extreme scenes whose hazard is geometry: each against brute force or a closed form.
#include <chrono>
#include <cstdlib>

#include "stress/scenes.h"
#include "stress/stress.h"

namespace tilecast::stress {
namespace {

// Ray number i of a scene.
using Aim = Ray (*)(Random& random, uint64_t i);

Case extreme(const char* name, uint64_t cases, const Scenes& (*scenes)(), Aim aim) {
  Case out{name, 0, "rays that differ from brute force", 0, Combine::Sum, cases, 100 * cases,
           against_brute_force(scenes, aim), 64};
  out.costs = [scenes, aim] {
    const Scene& scene = *scenes()[1];
    Random random(0);
    uint64_t rays = 0;
    double seconds = 0.0;
    for (auto start = std::chrono::steady_clock::now(); seconds < 0.1;
         seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count())
      for (int k = 0; k < 64; ++k) closest(scene, aim(random, rays++));
    return Costs{scene.accelerator.seconds, scene.accelerator.bytes, rays / seconds};
  };
  return out;
}

Scenes scenes_of(const MeshSource& source) {
  return for_each_kind([&](std::string_view kind) {
    SceneBuilder builder;
    uint32_t mesh = builder.add_mesh(source.build(), kind);
    return builder.build(mesh, {});
  });
}

// --- A ball on a floor a million times as large, in one mesh.

MeshSource stadium_mesh() {
  MeshSource all = icosphere(1).transformed(1.0, Vec3(3e5, 1.0, -2e5));
  constexpr int kSquares = 8;
  constexpr double kHalf = 5e5;
  uint32_t first = static_cast<uint32_t>(all.vertices.size());
  for (int i = 0; i <= kSquares; ++i)
    for (int j = 0; j <= kSquares; ++j)
      all.vertices.push_back({kHalf * (2.0 * i / kSquares - 1.0), 0.0, kHalf * (2.0 * j / kSquares - 1.0)});
  for (uint32_t i = 0; i < kSquares; ++i)
    for (uint32_t j = 0; j < kSquares; ++j) {
      uint32_t a = first + i * (kSquares + 1) + j, b = a + kSquares + 1;
      all.faces.insert(all.faces.end(), {{a, a + 1, b + 1}, {a, b + 1, b}});
    }
  return all;
}
const Scenes& stadium() {
  static const Scenes all = scenes_of(stadium_mesh());
  return all;
}
Ray at_stadium(Random& random, uint64_t i) {
  Vec3 ball{3e5, 1.0, -2e5}, target = ball + std::uniform_real_distribution<double>(0, 1.5)(random) * random_direction(random);
  Vec3 from = (i & 1 ? 4.0 : 1e5) * random_direction(random);
  from.y = std::fabs(from.y);
  return {ball + from, target - (ball + from)};
}

// --- Long thin triangles all through each other, along the diagonal: every box is nearly the whole.

#ifdef __SANITIZE_ADDRESS__
constexpr uint32_t kNeedles = 10'000;
#else
constexpr uint32_t kNeedles = 100'000;
#endif

MeshSource needle_mesh(uint32_t count) {
  Random random(100);
  std::uniform_real_distribution<double> unit(-1, 1);
  MeshSource out;
  for (uint32_t i = 0; i < count; ++i) {
    Vec3 start = 0.2 * Vec3(unit(random), unit(random), unit(random)), along = Vec3(1.0) + 0.05 * random_direction(random);
    out.vertices.insert(out.vertices.end(), {start - along, start + along, start + 1e-3 * random_direction(random)});
    out.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return out;
}
const Scenes& needles() {
  static const Scenes all = scenes_of(needle_mesh(kNeedles));
  return all;
}
Ray at_needles(Random& random, uint64_t) { return random_ray(random, 3.0); }

// --- One primitive, no primitive

const Scenes& one_primitive() {
  static const Scenes all = scenes_of({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}});
  return all;
}
const Scenes& empty() {
  static const Scenes all = for_each_kind([](std::string_view kind) {
    SceneBuilder builder;
    return scene_of(builder, {}, kind);
  });
  return all;
}
Ray anywhere(Random& random, uint64_t) { return random_ray(random, 1.5); }

// --- A closed mesh 1e6 and 2^40 from the world's origin, turned: no ray from inside leaves it, and t is that of the same
// scene about the origin, up to what positions there can tell apart.

struct Faraway {
  Vec3 offset;
  std::shared_ptr<const Scene> near, far;
};

const std::vector<Faraway>& faraway() {
  static const std::vector<Faraway> all = [] {
    std::vector<Faraway> out;
    for (double distance : {1e6, 0x1p40})
      for (const MeshSource& source : {icosphere(3), gridded_cube(4)}) {
        std::shared_ptr<const Scene> scenes[2];
        Vec3 offset = distance * Vec3(1.0, -0.75, 0.5);
        Affine turn = rotate(0.7, glm::normalize(Vec3(1, 2, 3)));
        for (int k = 0; k < 2; ++k) {
          SceneBuilder builder;
          uint32_t mesh = builder.add_mesh(source.build(), "auto");
          scenes[k] = scene_of(builder, {{mesh, k ? translate(offset) * turn : turn}});
        }
        out.push_back({offset, scenes[0], scenes[1]});
      }
    return out;
  }();
  return all;
}

bool faraway_is_wrong(Random& random, uint64_t i) {
  const Faraway& pair = faraway()[i % faraway().size()];
  Vec3 inside = pair.offset + 0.8 * random_direction(random);
  Vec3 rounded = inside - pair.offset;  // exact
  Vec3 direction = random_direction(random);
  Hit near = closest(*pair.near, {rounded, direction}), far = closest(*pair.far, {inside, direction});
  // From one point both take the same way into the mesh's space.
  return !near.found() || !far.found() || std::fabs(near.t - far.t) > 1e-12 || near.primitive != far.primitive;
}

// --- Vertices that are not finite, too large, too small.

bool odd_mesh_is_wrong(Random& random, uint64_t i) {
  static const double overflow = std::strtod("1e999", nullptr);
  const double oddities[] = {std::nan(""), kInfinity, -kInfinity, overflow, 1e308, -1e101,
                             1e-320, -1e-320, 0.0, -0.0, 1e-300, 1e99};
  MeshSource source = icosphere(0);
  int changes = 1 + static_cast<int>(i % 3);
  for (int k = 0; k < changes; ++k) {
    Vec3& vertex = source.vertices[random() % source.vertices.size()];
    vertex[random() % 3] = oddities[random() % std::size(oddities)];
  }
  bool fit = std::all_of(source.vertices.begin(), source.vertices.end(),
                         [](const Vec3& v) { return is_finite(v) && max_abs(v) <= 1e100; });
  Scenes scenes;
  try {
    scenes = scenes_of(source);
  } catch (const Error& error) {
    return fit || std::string(error.what()).find("vertices[") != 0;
  }
  if (!fit) return true;
  for (int k = 0; k < 4; ++k) {
    Ray ray = random_ray(random, 2.0);
    Answers expected, found;
    expected.ask(*scenes[0], ray);
    if (std::isnan(expected.hit.t) || std::isnan(expected.hit.u) || !expected.consistent()) return true;
    for (size_t other = 1; other < scenes.size(); ++other) {
      found.ask(*scenes[other], ray);
      if (!(found == expected)) return true;
    }
  }
  return false;
}

// --- Rays at 89.9999 degrees from a floor's normal meet it where the plane is.

double grazing_error(Random& random, uint64_t) {
  static const std::shared_ptr<const Scene> scene = [] {
    SceneBuilder builder;
    uint32_t slab = builder.add_mesh(gridded_cube(16).build(), "auto");
    return scene_of(builder, {{slab, Affine{}}});
  }();
  std::uniform_real_distribution<double> unit(-0.9, 0.9), turn(0, 1);
  double steep = 1.7453292519943296e-6;  // 90 degrees less 89.9999
  Vec3 target{unit(random), 1.0, unit(random)}, level = random_direction(random);
  level.y = 0.0;
  Vec3 direction = glm::normalize(level) - Vec3(0.0, steep, 0.0);
  Ray ray{target - (0.5 + turn(random)) * 1e3 * direction, direction};
  Hit hit = closest(*scene, ray);
  if (!hit.found()) return kInfinity;
  // The face's plane is exactly y = 1: the hit's height above it is its error.
  return std::fabs(std::fma(hit.t, direction.y, ray.origin.y) - 1.0) / (8 * 0x1p-24 * 2.0);
}

}  // namespace

void add_extreme_geometry(std::vector<Case>& out) {
  out.push_back(extreme("stadium", 20'000, stadium, at_stadium));
  out.push_back(extreme("needles", 200, needles, at_needles));
  out.push_back(extreme("one-primitive", 300'000, one_primitive, anywhere));
  out.push_back(extreme("empty", 300'000, empty, anywhere));
  out.push_back({"world-offset", 0, "leaks, and hits unlike those about the origin", 0, Combine::Sum, 500'000, 100'000'000,
                 sum_of(faraway_is_wrong)});
  out.push_back({"odd-vertices", 0, "built or refused wrongly", 0, Combine::Sum, 4'000, 10'000'000,
                 sum_of(odd_mesh_is_wrong), 256});
  out.push_back({"grazing", 0, "error of hits at 89.9999 degrees, in 8 u of the extent", 1, Combine::Max, 500'000, 100'000'000,
                 worst_of(grazing_error)});
}

}  // namespace tilecast::stress
