// Whitted's ray trees of many camera rays at once. In turns each tree's next branch is traced, eight at a time
// (scene/packet.h); hits on one primitive are then shaded eight at a time, where there are lanes for what it is, and shadow
// rays go together as well.
#include <utility>

#include "integrators/whitted_branch.h"
#include "optics/fresnel_lanes.h"
#include "scene/packet.h"
#include "scene/surface_lanes.h"
#include "shading/basis_lanes.h"

namespace tilecast {
namespace {

// What is shaded in lanes: surfaces that scatter alike in all directions, lit by points alone, and smooth glass.
bool is_plain(const Material& m) {
  return m.opacity == 1.0 && !m.emits() && m.opacity_texture < 0 && m.emission_texture < 0 && m.roughness_texture < 0 &&
         m.normal_map < 0 && !m.uses_uv;
}
bool has_lambert_lanes(const Scene& scene, const Material& m) {
  return m.kind == MaterialKind::Diffuse && m.roughness == 0.0 && is_plain(m) &&
         scene.lights.count() == scene.lights.points.size();
}
bool has_glass_lanes(const Material& m) {
  return m.kind == MaterialKind::Dielectric && m.refracts && m.smooth() && m.texture < 0 && is_plain(m);
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
          push(live_.back().top, {camera.ray, Rgb(1.0), *camera.media, 1}, kCamera);
        else
          push(live_.back().top, {camera.ray, Rgb(1.0), {}, 1}, kCamera);
      }
      step();
    }
    tracing_.counts.camera += cameras_.size();
  }

 private:
  static constexpr size_t kAtOnce = 512;  // their branches stay in the cache
  static constexpr uint32_t kNone = ~0u;
  static constexpr uint32_t kCamera = 2 * Ways::kSlots, kPlaces = kCamera + 1;

  // Rays that leave one primitive on one side are alike.
  static uint32_t place_of(const Hit& hit, bool other_side) {
    return static_cast<uint32_t>(2 * Ways::slot_of(hit.primitive) + (hit.entering == other_side));
  }

  struct Kept {
    Branch<kPassable> branch;
    uint32_t below;  // on the same stack
    uint32_t from;   // what it leaves, as place_of() numbers it
  };
  struct Live {
    uint32_t camera, top;  // its number, and the top of its stack
  };
  struct Lit {
    uint32_t camera;
    Rgb weight;
  };
  struct Key {
    uint32_t live, key;
  };

  // Whether nothing comes of the hit: the last one is followed by none, and it does not shine itself.
  bool ends_unseen(const Branch<kPassable>& branch, const Material& material, const Hit& hit) const {
    if (branch.depth != scene_.max_depth || material.emits()) return false;
    return !kPassable || !passable(material) || (material.opacity == 1.0 && branch.media.at(material, hit.entering).real);
  }

  Branch<kPassable>& push(uint32_t& top, const Branch<kPassable>& branch, uint32_t from) {
    uint32_t at = static_cast<uint32_t>(kept_.size());
    if (free_ != kNone)
      at = std::exchange(free_, kept_[free_].below), kept_[at].branch = branch;
    else
      kept_.push_back({branch, kNone, kCamera});
    kept_[at].below = std::exchange(top, at);
    kept_[at].from = from;
    return kept_[at].branch;
  }

  // The first branch of each.
  void step() {
    rays_.clear(), lit_.clear(), shadows_.clear();
    by_place();
    for (const Live& live : live_) rays_.push_back(kept_[live.top].branch.ray);
    hits_.resize(rays_.size());
    closest(scene_, rays_, hits_.data());
    sort();
    for (size_t begin = 0; begin < order_.size();) {
      const Hit& first = hits_[order_[begin]];
      size_t end = begin + 1;
      while (end < order_.size() && end - begin < kLanes && hits_[order_[end]].primitive == first.primitive &&
             hits_[order_[end]].entering == first.entering)
        ++end;
      shade_alike(std::span(order_).subspan(begin, end - begin));
      begin = end;
    }
    unshadowed(scene_, std::span<ShadowRay<kPassable>>(shadows_), ways_, tracing_);
    for (size_t i = 0; i < lit_.size(); ++i) cameras_[lit_[i].camera].value += lit_[i].weight * shadows_[i].left;
    std::erase_if(live_, [](const Live& live) { return live.top == kNone; });
  }

  // Those whose next rays leave from one place together; others stay as they are.
  void by_place() {
    uint32_t begin[kPlaces + 1] = {};
    for (const Live& live : live_) ++begin[kept_[live.top].from + 1];
    if (begin[kCamera + 1] == live_.size()) return;
    for (uint32_t k = 1; k <= kPlaces; ++k) begin[k] += begin[k - 1];
    sorted_.resize(live_.size());
    for (const Live& live : live_) sorted_[begin[kept_[live.top].from]++] = live;
    live_.swap(sorted_);
  }

  // Hits on one primitive together. What hits nothing, or where nothing comes of it, ends here.
  void sort() {
    uint32_t begin[2 * Ways::kSlots + 1] = {};
    keys_.clear(), order_.clear();
    for (uint32_t i = 0; i < live_.size(); ++i) {
      const Hit& hit = hits_[i];
      const Branch<kPassable>& branch = kept_[live_[i].top].branch;
      if (!hit.found()) {
        cameras_[live_[i].camera].value += seen_beyond(scene_, branch);
        pop(live_[i]);
      } else if (branch.depth == scene_.max_depth && ends_unseen(branch, *ways_.to(hit.primitive).material, hit)) {
        pop(live_[i]);
      } else {
        const uint32_t key = static_cast<uint32_t>(2 * Ways::slot_of(hit.primitive) + hit.entering);
        ++begin[key + 1];
        keys_.push_back({i, key});
      }
    }
    for (size_t k = 1; k <= 2 * Ways::kSlots; ++k) begin[k] += begin[k - 1];
    order_.resize(keys_.size());
    for (const Key& key : keys_) order_[begin[key.key]++] = key.live;
  }

  void pop(Live& live) {
    const uint32_t gone = std::exchange(live.top, kept_[live.top].below);
    kept_[gone].below = std::exchange(free_, gone);
  }

  void shade_one(uint32_t i, const Ways::Way& way) {
    Live& live = live_[i];
    CameraRay& camera = cameras_[live.camera];
    Branch<kPassable> branch = kept_[live.top].branch;
    pop(live);
    shade<kPassable>(
        scene_, branch, hits_[i], camera.sampler, camera.value, tracing_,
        [&](const Hit& hit) { return ways_.resolve(way, branch.ray, hit); },
        [&](const Branch<kPassable>& next) -> Branch<kPassable>& { return push(live.top, next, place_of(hits_[i], false)); },
        [&](const Rgb& weight, const Ray& ray, const MediaOf<kPassable>& media, size_t light, Glass glass) {
          lit_.push_back({live.camera, weight});
          if constexpr (kPassable)
            shadows_.push_back({ray, media, glass, refracting(scene_, light)});
          else
            shadows_.push_back({ray});
        });
  }

  // At most eight hits on one primitive, on one side of it.
  void shade_alike(std::span<const uint32_t> alike) {
    const Hit& first = hits_[alike[0]];
    const Ways::Way& way = ways_.to(first.primitive);
    if (alike.size() > 1 && has_lanes(scene_, way)) {
      const Material& material = *way.material;
      if (has_lambert_lanes(scene_, material)) return shade_lambert(alike, way);
      if (kPassable && has_glass_lanes(material)) return shade_glass(alike, way);
    }
    for (uint32_t i : alike) shade_one(i, way);
  }

  struct Lanes {
    Vec3Lanes origin, direction, weight;
    Double8 t, scale;
    SurfaceLanes surface;
  };
  void gather(std::span<const uint32_t> alike, const Ways::Way& way, Lanes& out) {
    for (size_t k = 0; k < kLanes; ++k) {
      const int lane = static_cast<int>(k);
      const uint32_t i = alike[std::min(k, alike.size() - 1)];
      const Branch<kPassable>& branch = kept_[live_[i].top].branch;
      out.origin.set(lane, branch.ray.origin), out.direction.set(lane, branch.ray.direction);
      out.weight.set(lane, branch.weight * branch.media.transmittance(hits_[i].t - branch.ray.t_min)), out.t.set(lane, hits_[i].t);
      out.scale.set(lane, branch.scale);
    }
    out.surface = resolve(scene_, way, out.origin, out.direction, out.t, hits_[alike[0]].entering);
  }

  void shade_lambert(std::span<const uint32_t> alike, const Ways::Way& way) {
    const Material& material = *way.material;
    uint32_t known = (1u << alike.size()) - 1;
    if (built_with("shadow_rays")) {
      Lanes lanes;
      gather(alike, way, lanes);
      const SurfaceLanes& surface = lanes.surface;
      known &= surface.known;
      Vec3Lanes reflectance(material.reflectance);
      if (is_texture(material.texture))
        for (size_t k = 0; k < alike.size(); ++k) {
          const int lane = static_cast<int>(k);
          Surface place;
          place.place = {surface.place[lane], surface.place_normal[lane], Vec2(0.0)};
          reflectance.set(lane, reflectance_at(scene_, place, material));
        }
      const Vec3Lanes normal = hits_[alike[0]].entering ? surface.normal : -surface.normal;
      for (const PointLight& light : scene_.lights.points) {
        const Vec3Lanes position(light.position), towards = position - surface.point;
        const Double8 distance2 = dot(towards, towards);
        const Vec3Lanes direction = towards / sqrt(distance2), radiance = Vec3Lanes(light.intensity) / distance2;
        const Double8 cosine = dot(direction, normal), pdf = choose(cosine > 0.0, cosine, 0.0) * Double8(kInvPi);
        const Vec3Lanes f = reflectance * pdf, weight = lanes.weight * f * radiance;
        const Mask8d finite = max_abs(radiance) < kInfinity;
        const Mask8d arrives = (distance2 > 0.0) & finite & (max_component(radiance) > 0.0) & (max_component(f) > 0.0);
        const Vec3Lanes start = surface.spawn(towards), to_light = position - start;
        for (uint32_t left = bits(arrives) & known; left != 0; left &= left - 1) {
          const int lane = std::countr_zero(left);
          const Live& live = live_[alike[lane]];
          lit_.push_back({live.camera, weight[lane]});
          const Ray shadow{start[lane], to_light[lane], 0.0, 1.0};
          if constexpr (kPassable)
            shadows_.push_back({shadow, kept_[live.top].branch.media});
          else
            shadows_.push_back({shadow});
        }
      }
    }
    for (size_t k = 0; k < alike.size(); ++k)
      if (known >> k & 1)
        pop(live_[alike[k]]);
      else
        shade_one(alike[k], way);
  }

  void shade_glass(std::span<const uint32_t> alike, const Ways::Way& way) {
    const Material& material = *way.material;
    const bool entering = hits_[alike[0]].entering;
    Double8 eta = 1.0;
    uint32_t real = 0;
    for (size_t k = 0; k < alike.size(); ++k) {
      const Boundary boundary = kept_[live_[alike[k]].top].branch.media.at(material, entering);
      eta.set(static_cast<int>(k), boundary.eta);
      real |= uint32_t(boundary.real) << k;
    }
    if (real != (1u << alike.size()) - 1) {
      for (uint32_t i : alike) shade_one(i, way);
      return;
    }
    Lanes lanes;
    gather(alike, way, lanes);
    const SurfaceLanes& surface = lanes.surface;
    const BasisLanes basis(entering ? surface.normal : -surface.normal);
    Vec3Lanes wo = basis.to_local(-lanes.direction);
    wo.z = choose(wo.z < 1e-12, 1e-12, wo.z);
    const FresnelLanes<Double8> fresnel = fresnel_dielectric(wo.z, eta);
    const Double8 transmitted = (Double8(1.0) - fresnel.reflectance) / (eta * eta);
    const Vec3Lanes weights[2] = {lanes.weight * fresnel.reflectance, lanes.weight * (Vec3Lanes(material.tint) * transmitted)};
    const Double8 scales[2] = {lanes.scale, lanes.scale * (eta * eta)};
    const Vec3Lanes wi[2] = {{-wo.x, -wo.y, wo.z}, {-wo.x / eta, -wo.y / eta, -fresnel.cos_transmitted}};
    Vec3Lanes starts[2], directions[2];
    uint32_t goes_on[2];
    for (int side = 0; side < 2; ++side) {
      directions[side] = normalize(basis.to_world(wi[side]));
      starts[side] = surface.spawn(directions[side]);
      goes_on[side] = ~bits(max_component(weights[side]) * scales[side] < kFaintest);
    }
    goes_on[1] &= ~bits(fresnel.total);
    for (size_t k = 0; k < alike.size(); ++k) {
      const int lane = static_cast<int>(k);
      Live& live = live_[alike[k]];
      if (!(surface.known >> k & 1)) {
        shade_one(alike[k], way);
        continue;
      }
      const uint32_t parent = live.top;
      const int depth = kept_[parent].branch.depth + 1;
      const bool reflected = goes_on[0] >> k & 1, refracted = goes_on[1] >> k & 1;
      const uint32_t places[2] = {place_of(hits_[alike[k]], false), place_of(hits_[alike[k]], true)};
      auto follow = [&](Branch<kPassable>& next, int side) {  // in the place of its parent, or a copy of that
        next.ray = {starts[side][lane], directions[side][lane]};
        next.weight = weights[side][lane];
        next.depth = depth;
        next.scale = scales[side][lane];
        next.pdf = 0.0;
        if (side == 1) next.media.cross(material, entering);
        ++tracing_.counts.bounce;
      };
      if (refracted && reflected) follow(push(live.top, kept_[parent].branch, places[1]), 1);
      if (reflected || refracted) {
        kept_[parent].from = places[!reflected];
        follow(kept_[parent].branch, !reflected);
      } else {
        pop(live);
      }
    }
  }

  const Scene& scene_;
  std::span<CameraRay> cameras_;
  Tracing& tracing_;
  Ways ways_;
  std::vector<Kept> kept_;
  uint32_t free_ = kNone;
  std::vector<Live> live_, sorted_;
  std::vector<Ray> rays_;
  std::vector<Hit> hits_;
  std::vector<Key> keys_;        // of the hits: what they are sorted by
  std::vector<uint32_t> order_;  // of those that live
  std::vector<Lit> lit_;
  std::vector<ShadowRay<kPassable>> shadows_;
};

}  // namespace

void trace_whitted(const Scene& scene, std::span<CameraRay> rays, Tracing& tracing) {
  if (passable(scene))
    Together<true>(scene, rays, tracing).run();
  else
    Together<false>(scene, rays, tracing).run();
}

}  // namespace tilecast
