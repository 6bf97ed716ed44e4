// Gate 30: no sample of any scene is NaN or infinite. Random scenes of everything that there is, with extreme parameters;
// a sample that is not finite makes render_chunk throw, and the case names its pixel, sample and seed.
#include <mutex>

#include "optics/spectrum.h"
#include "render/chunk.h"
#include "scene/sky.h"
#include "stress/scenes.h"
#include "stress/shapes.h"
#include "stress/stress.h"

namespace tilecast::stress {
namespace {

constexpr int kSide = 64;                       // pixels of an image
constexpr uint64_t kPixels = kSide * kSide, kShare = 8;  // samples of each pixel in a row
constexpr size_t kScenes = 512;                 // made where they are asked for: energy tables take long

template <class T>
T one_of(Random& random, std::initializer_list<T> values) {
  return values.begin()[random() % values.size()];
}
bool once_in(Random& random, uint64_t times) { return random() % times == 0; }

// Black, white, or something between.
Rgb random_share(Random& random) {
  Rgb out;
  for (int c = 0; c < 3; ++c) out[c] = one_of(random, {0.0, 1.0, uniform(random, 0, 1), power_of_ten(random, -12, 0)});
  return out;
}
Rgb random_radiance(Random& random) { return power_of_ten(random, -30, 30) * random_share(random); }

// `rough`: the roughness of what is not polished, one for each scene.
Material random_material(Random& random, SceneBuilder& builder, double rough) {
  using enum MaterialKind;
  Material m;
  m.kind = one_of(random, {Diffuse, Mirror, Conductor, Dielectric, Dielectric, Plastic, Phong});
  m.reflectance = random_share(random);
  const double roughness = once_in(random, 3) ? rough : 0.0;
  switch (m.kind) {
    case Diffuse: m.roughness = roughness; break;
    case Conductor:
      m.roughness = roughness;
      if (random() & 1)
        for (int c = 0; c < 3; ++c) m.eta[c] = power_of_ten(random, -3, 3), m.k[c] = power_of_ten(random, -3, 3);
      break;
    case Dielectric:
      m.ior = one_of(random, {1.5, 1.0, 1.0 + 1e-12, 1.0 + 1e-6, 1e-3, 1e3, power_of_ten(random, -1, 1)});
      m.roughness = once_in(random, 8) ? roughness : 0.0;  // half a second for its tables
      m.tint = random_share(random);
      if (random() & 1) m.absorption = power_of_ten(random, -6, 6) * random_share(random);
      m.priority = static_cast<int>(random() % 3);
      if (m.roughness == 0.0 && once_in(random, 4)) m.abbe = power_of_ten(random, 0, 3);
      if (m.abbe != 0.0 && least_ior(m.ior, m.abbe) < kLeastIor) m.abbe = 0.0;  // is refused
      break;
    case Plastic:
      m.ior = one_of(random, {1.5, 1.0, 1.0 + 1e-9, 1e3});
      m.roughness = roughness;
      break;
    case Phong:
      m.specular = (Rgb(1.0) - m.reflectance) * random_share(random);
      m.exponent = one_of(random, {0.0, 1.0, 50.0, 1e6});
      break;
    default: break;
  }
  if (once_in(random, 4)) m.opacity = one_of(random, {0.0, 0.5, 1.0 - 1e-12});
  if (once_in(random, 5)) m.emission = random_radiance(random);
  if (m.kind != Phong && once_in(random, 3))  // Phong's is bounded by what its specular part leaves
    m.texture = builder.add_texture(random() & 1 ? Texture{Checker{random_share(random), random_share(random), 0.3, false}}
                                                 : Texture{Gradient{random_share(random), random_share(random), 1, -1, 1}});
  return m;
}

// Solids at unit size, a mesh, a CSG, open surfaces: one of them.
uint32_t random_object(Random& random, SceneBuilder& builder) {
  auto solid = [&](Affine& to_unit, int kinds = kSolidKinds) {
    const Solid found = random_solid(static_cast<int>(random() % kinds), random);
    to_unit = scale(Vec3(1.0 / size_of(found)));
    return builder.add_solid(found);
  };
  static_assert(std::is_same_v<std::variant_alternative_t<kSolidKinds - 1, Solid>, Halfspace>);
  auto operand = [&](Affine& to_unit) { return solid(to_unit, kSolidKinds - 1); };  // not a halfspace with an end of its own
  Affine a, b;
  switch (random() % 6) {
    case 0: return builder.add_mesh(icosphere(1).build(), "auto");
    case 1: return builder.add_flat(Disk{1.0});
    case 2: {
      const uint32_t first = operand(a);
      if (once_in(random, 4)) {
        const uint32_t half = builder.add_solid(Halfspace::of(random_direction(random), uniform(random, -0.5, 0.5)));
        return builder.add_csg(one_of(random, {CsgOperation::Intersection, CsgOperation::Difference}), {{first, a}, {half, Affine{}}});
      }
      const uint32_t second = operand(b);
      return builder.add_csg(one_of(random, {CsgOperation::Union, CsgOperation::Intersection, CsgOperation::Difference}),
                             {{first, a}, {second, b}});
    }
    default: {
      const uint32_t found = solid(a);
      return builder.add_group({{found, a}}, "auto");
    }
  }
}

void add_lights(Random& random, SceneBuilder& builder) {
  for (uint64_t left = random() % 3; left > 0; --left)
    builder.add_point_light({2.0 * random_direction(random), random_radiance(random)});
  if (random() & 1)
    builder.add_spot_light({2.0 * random_direction(random), random_direction(random), random_radiance(random), 0.99, 0.9});
  if (random() & 1) builder.add_directional_light({random_direction(random), random_radiance(random)});
  switch (random() % 4) {
    case 0: builder.set_background(random_radiance(random)); break;
    case 1: builder.set_environment(make_environment(Sky{Vec3(0.3, uniform(random, 0.0, 1.0), 0.2)})); break;
    case 2: {
      std::vector<Vec3f> pixels(32, Vec3f(0.0f));
      for (uint64_t left = random() % 8; left > 0; --left) pixels[random() % 32] = Vec3f(random_radiance(random));
      builder.set_environment(Environment(pixels, 8, 4, uniform(random, -180, 180)));
      break;
    }
    default: break;
  }
}

Camera random_camera(Random& random) {
  const View view{3.0 * random_direction(random), Vec3(0.0), Vec3(0.1, 1.0, 0.2), kSide, kSide};
  switch (random() % 6) {
    case 0: return Camera::orthographic(view, 3.0);
    case 1: return Camera::thin_lens(view, 40.0, one_of(random, {1e-6, 0.5}), 3.0);
    case 2: return Camera::panorama({0.3 * random_direction(random), Vec3(0.0), Vec3(0.1, 1.0, 0.2), kSide, kSide});
    default: return Camera::perspective(view, one_of(random, {1.0, 40.0, 150.0}));
  }
}

std::shared_ptr<const Scene> random_scene(uint64_t number) {
  Random random(number);
  SceneBuilder builder;
  const double rough = one_of(random, {kLeastRoughness, 0.02, 0.5, 1.0});
  auto material = [&] { return builder.add_material(random_material(random, builder, rough)); };
  std::vector<InstanceSource> instances;
  for (uint64_t left = 1 + random() % 6; left > 0; --left) {
    const uint32_t object = random_object(random, builder);
    instances.push_back({object, random_affine(random), material()});
  }
  if (once_in(random, 3)) instances.push_back(instances.back());  // twice at one place
  instances.push_back({builder.add_rectangle(20, 20), translate(Vec3(0, -1.5, 0)), material()});
  add_lights(random, builder);
  builder.set_camera(random_camera(random));
  builder.set_filter(static_cast<PixelFilter::Kind>(random() % 5));
  SceneBuilder::Options options;
  options.integrator = one_of(random, {Integrator::Path, Integrator::Path, Integrator::Path, Integrator::Direct,
                                       Integrator::Whitted, Integrator::AmbientOcclusion});
  options.max_depth = options.integrator == Integrator::Whitted ? 6 : one_of(random, {2, 8, 40});
  options.seed = static_cast<uint32_t>(number);
  options.next_event = !once_in(random, 4);
  options.roulette = !once_in(random, 4);
  options.sampling = random() & 1 ? Sampling::Sobol : Sampling::Independent;
  return scene_of(builder, instances, "auto", options);
}

const Scene& scene_number(size_t number) {
  struct Slot {
    std::once_flag made;
    std::shared_ptr<const Scene> scene;
  };
  static std::vector<Slot> slots(kScenes);
  std::call_once(slots[number].made, [&] { slots[number].scene = random_scene(number); });
  return *slots[number].scene;
}

// Samples first .. first + count - 1 of all, kShare of each pixel of a scene in a row: throws at the first that is not
// finite. Whole images, so that a few more may be taken.
double not_finite(uint64_t first, uint64_t count) {
  const uint64_t row = first / (kPixels * kShare);
  const Scene& scene = scene_number(row % kScenes);
  const auto samples = static_cast<uint32_t>((count + kPixels - 1) / kPixels);
  double wrong = 0.0;
  for (double sum : render_chunk(scene, {0, 0, kSide, kSide}, static_cast<uint32_t>(row / kScenes * kShare), samples).sums)
    wrong += !std::isfinite(sum);
  return wrong;
}

}  // namespace

void add_samples(std::vector<Case>& out) {
  out.push_back({"finite-samples", 30, "samples that are not finite", 0, Combine::Sum, 1'000'000, 10'000'000'000, not_finite,
                 kPixels * kShare});
}

}  // namespace tilecast::stress
