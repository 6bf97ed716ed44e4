#include <utility>

#include "integrators/direct.h"
#include "integrators/shadow.h"
#include "scene/packet.h"
#include "shading/bsdf.h"

namespace tilecast {
namespace {

// Branches that would add less than this share of the pixel are not followed (Hall and Greenberg, "A Testbed for
// Realistic Image Synthesis", 1983).
constexpr double kFaintest = 1e-5;

template <bool kPassable>
struct Branch {
  Ray ray;
  Rgb weight;
  MediaOf<kPassable> media;
  int depth;
};

// What a branch adds to the sum where it ends, without what lights do: light(weight, shadow ray, media, light) is called
// for each that may reach the place, and push(branch) for the branches that go on from there, the last of them first.
// resolved(hit) is its surface.
template <bool kPassable, class Resolve, class Push, class Light>
void shade(const Scene& scene, Branch<kPassable>& branch, const Hit& hit, Sampler& sampler, Rgb& sum, Tracing& tracing,
           Resolve&& resolved, Push&& push, Light&& light) {
  if (!hit.found()) {
    sum += branch.weight * branch.media.transmittance(kInfinity) * background(scene, branch.ray.direction);
    return;
  }
  Surface surface = resolved(hit);
  const Material& material = *surface.material;
  Vec3 wo_world = -branch.ray.direction;
  branch.weight *= branch.media.transmittance(hit.t - branch.ray.t_min);
  Boundary boundary;
  if (kPassable && passable(material)) {
    boundary = branch.media.at(material, hit.entering);
    const double opacity = opacity_at(scene, surface);
    double through = boundary.real ? (1.0 - opacity) / (boundary.eta * boundary.eta) : 1.0;
    if (through * max_component(branch.weight) >= kFaintest) {
      Branch<kPassable>& straight = push(branch);
      straight.ray.t_min = hit.t;
      straight.weight *= through;
      straight.media.cross(material, hit.entering);
      ++tracing.counts.bounce;
    }
    if (!boundary.real) return;
    branch.weight *= opacity;
  }
  if (built_with("emission") && hit.entering && material.emits()) sum += branch.weight * emission_at(scene, surface);
  if (branch.depth == scene.max_depth) return;

  Basis basis(hit.entering ? surface.normal : -surface.normal);
  Vec3 wo = basis.to_local(wo_world);
  wo.z = std::max(wo.z, 1e-12);
  auto follow = [&](const Vec3& wi, const Rgb& weight) {
    if (max_component(weight) < kFaintest) return;
    Vec3 direction = glm::normalize(basis.to_world(wi));
    Branch<kPassable>& next = push({{surface.spawn(direction), direction}, weight, branch.media, branch.depth + 1});
    if (wi.z < 0.0) next.media.cross(material, hit.entering);
    ++tracing.counts.bounce;
  };
  Bsdf bsdf(scene, surface, boundary);
  if (built_with("shadow_rays") && !bsdf.specular())
    for (size_t number = 0; number < scene.lights.count(); ++number) {
      DirectLight direct = sample_direct(scene, surface, {number, 1.0}, sampler);
      if (!direct.arrives()) continue;
      double pdf;
      Rgb f = bsdf.evaluate(wo, basis.to_local(direct.direction), pdf);
      if (!(max_component(f) > 0.0)) continue;
      light(branch.weight * f * direct.radiance, direct.shadow, branch.media, number);
    }
  Beam beams[kMostBeams];
  for (int i = 0, count = bsdf.beams(wo, beams); i < count; ++i) follow(beams[i].wi, branch.weight * beams[i].weight);
  BsdfSample scattered;
  if (bsdf.sample_glossy(wo, sampler, scattered)) follow(scattered.wi, branch.weight * scattered.weight);
}

template <bool kPassable>
Rgb trace(const Scene& scene, const Ray& camera_ray, const MediaOf<kPassable>& camera_media, Sampler& sampler,
          Tracing& tracing) {
  thread_local std::vector<Branch<kPassable>> kept;  // from ray to ray, so that tracing does not allocate
  std::vector<Branch<kPassable>>& pending = kept;
  pending.clear();
  pending.push_back({camera_ray, Rgb(1.0), camera_media, 1});
  ++tracing.counts.camera;
  Rgb sum(0.0);
  while (!pending.empty()) {
    Branch<kPassable> branch = pending.back();
    pending.pop_back();
    shade<kPassable>(
        scene, branch, closest(scene, branch.ray), sampler, sum, tracing,
        [&](const Hit& hit) { return resolve(scene, branch.ray, hit); },
        [&](const Branch<kPassable>& next) -> Branch<kPassable>& { return pending.emplace_back(next); },
        [&](const Rgb& weight, const Ray& ray, const MediaOf<kPassable>& media, size_t light) {
          sum += weight * unshadowed(scene, ray, media, Glass::Passes, light, tracing);
        });
  }
  return sum;
}

// Many camera rays on their way at once, each with its own stack of branches, so that neighbours are asked for together.
// What one adds up, and in which order, does not depend on the others.
template <bool kPassable>
class Together {
 public:
  Together(const Scene& scene, std::span<CameraRay> cameras, Tracing& tracing)
      : scene_(scene), cameras_(cameras), tracing_(tracing), ways_(scene) {}

  void run() {
    for (size_t begun = 0; begun < cameras_.size() || !live_.empty();) {
      for (; live_.size() < kAtOnce && begun < cameras_.size(); ++begun) {
        CameraRay& camera = cameras_[begun];
        camera.value = Rgb(0.0);
        live_.push_back({static_cast<uint32_t>(begun), kNone});
        if constexpr (kPassable)
          push(live_.back().top, {camera.ray, Rgb(1.0), *camera.media, 1});
        else
          push(live_.back().top, {camera.ray, Rgb(1.0), {}, 1});
      }
      step();
    }
    tracing_.counts.camera += cameras_.size();
  }

 private:
  static constexpr size_t kAtOnce = 512;  // their branches stay in the cache
  static constexpr uint32_t kNone = ~0u;

  struct Kept {
    Branch<kPassable> branch;
    uint32_t below;  // on the same stack
  };
  struct Live {
    uint32_t camera, top;  // its number, and the top of its stack
  };
  struct Lit {
    uint32_t camera;
    Rgb weight;
  };

  // Whether nothing comes of the hit: the last one is followed by none, and it does not shine itself.
  bool ends_unseen(const Branch<kPassable>& branch, const Material& material, const Hit& hit) const {
    if (branch.depth != scene_.max_depth || material.emits()) return false;
    return !kPassable || !passable(material) || (material.opacity == 1.0 && branch.media.at(material, hit.entering).real);
  }

  Branch<kPassable>& push(uint32_t& top, const Branch<kPassable>& branch) {
    uint32_t at = static_cast<uint32_t>(kept_.size());
    if (free_ != kNone)
      at = std::exchange(free_, kept_[free_].below), kept_[at].branch = branch;
    else
      kept_.push_back({branch, kNone});
    kept_[at].below = std::exchange(top, at);
    return kept_[at].branch;
  }

  // The first branch of each.
  void step() {
    rays_.clear(), lit_.clear(), shadows_.clear();
    for (const Live& live : live_) rays_.push_back(kept_[live.top].branch.ray);
    hits_.resize(rays_.size());
    closest(scene_, rays_, hits_.data());
    for (size_t i = 0; i < live_.size(); ++i) {
      Live& live = live_[i];
      CameraRay& camera = cameras_[live.camera];
      Kept& first = kept_[live.top];
      Branch<kPassable> branch = first.branch;
      const uint32_t gone = std::exchange(live.top, first.below);
      first.below = std::exchange(free_, gone);
      const Ways::Way* way = hits_[i].found() ? &ways_.to(hits_[i].primitive) : nullptr;
      if (way && ends_unseen(branch, *way->material, hits_[i])) continue;
      shade<kPassable>(
          scene_, branch, hits_[i], camera.sampler, camera.value, tracing_,
          [&](const Hit& hit) { return ways_.resolve(*way, branch.ray, hit); },
          [&](const Branch<kPassable>& next) -> Branch<kPassable>& { return push(live.top, next); },
          [&](const Rgb& weight, const Ray& ray, const MediaOf<kPassable>& media, size_t) {
            lit_.push_back({live.camera, weight});
            shadows_.push_back({ray, media});
          });
    }
    unshadowed(scene_, std::span<ShadowRay<kPassable>>(shadows_), Glass::Passes, tracing_);
    for (size_t i = 0; i < lit_.size(); ++i) cameras_[lit_[i].camera].value += lit_[i].weight * shadows_[i].left;
    std::erase_if(live_, [](const Live& live) { return live.top == kNone; });
  }

  const Scene& scene_;
  std::span<CameraRay> cameras_;
  Tracing& tracing_;
  Ways ways_;
  std::vector<Kept> kept_;
  uint32_t free_ = kNone;
  std::vector<Live> live_;
  std::vector<Ray> rays_;
  std::vector<Hit> hits_;
  std::vector<Lit> lit_;
  std::vector<ShadowRay<kPassable>> shadows_;
};

}  // namespace

Rgb trace_whitted(const Scene& scene, const Ray& ray, const Media& media, Sampler& sampler, Tracing& tracing) {
  if (passable(scene)) return trace<true>(scene, ray, media, sampler, tracing);
  return trace<false>(scene, ray, {}, sampler, tracing);
}

void trace_whitted(const Scene& scene, std::span<CameraRay> rays, Tracing& tracing) {
  if (passable(scene))
    Together<true>(scene, rays, tracing).run();
  else
    Together<false>(scene, rays, tracing).run();
}

}  // namespace tilecast
