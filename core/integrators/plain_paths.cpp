#include "integrators/plain_paths.h"

#include <bit>

#include "integrators/direct.h"
#include "integrators/plain_surface.h"
#include "integrators/roulette.h"

namespace tilecast {
namespace {

// A density that can be divided by: as in direct.cpp.
Mask4 usable(Double4 pdf) { return (pdf > 1e-150) & (pdf < 1e150); }

Uint4 narrow(Mask4 x) { return __builtin_convertvector(x, Uint4); }

Double4 power_heuristic(Double4 a, Double4 b) {
  const Double4 ratio = b / a;
  return 1.0 / (1.0 + ratio * ratio);
}

// square_to_disk and cosine_hemisphere.
[[gnu::always_inline]] inline Vec3x4 cosine_hemisphere(Double4 u, Double4 v) {
  const Double4 a = 2.0 * u - 1.0, b = 2.0 * v - 1.0;
  const Mask4 wide = abs(a) > abs(b);
  const Double4 r = wide ? a : b, part = 0.125 * ((wide ? b : a) / r);
  Double4 turn = wide ? part : 0.25 - part;
  turn = turn < 0.0 ? turn + 1.0 : turn;
  turn = (a == 0.0) & (b == 0.0) ? all(0.0) : turn;  // r is 0 as well
  Double4 sine, cosine;
  sincos_2pi(turn, sine, cosine);
  const Double4 x = r * cosine, y = r * sine, rest = 1.0 - (x * x + y * y);
  return {x, y, sqrt(max(all(0.0), rest))};
}

}  // namespace

PlainPaths::PlainPaths(const Scene& scene, const PlainScene& plain)
    : scene_(scene), plain_(plain),
      max_depth_(scene.integrator == Integrator::Direct ? std::min(2, scene.max_depth) : scene.max_depth) {
  for (Lane* lanes : {origin_, direction_, throughput_, sum_})
    for (int i = 0; i < 3; ++i) std::fill(std::begin(lanes[i].at), std::end(lanes[i].at), 0.0);
  std::fill(std::begin(bsdf_pdf_.at), std::end(bsdf_pdf_.at), 0.0);
  std::fill(std::begin(scale_.at), std::end(scale_.at), 1.0);
  for (Number* numbers : {&key_, &index_, &path_, &inside_, &taken_}) std::fill(std::begin(numbers->at), std::end(numbers->at), 0);
}

void PlainPaths::add(const Ray& ray, const Sampler& sampler, Seen seen) {
  for (int c = 0; c < 3; ++c) {
    origin_[c].at[count_] = ray.origin[c];
    direction_[c].at[count_] = ray.direction[c];
  }
  by_pixels_ = false;
  start(sampler, seen);
}

void PlainPaths::add(uint32_t x, uint32_t y, const Sampler& sampler, Seen seen) {
  origin_[0].at[count_] = x;
  origin_[1].at[count_] = y;
  by_pixels_ = true;
  start(sampler, seen);
}

void PlainPaths::start(const Sampler& sampler, Seen seen) {
  const uint32_t i = count_++;
  key_.at[i] = sampler.key();
  index_.at[i] = sampler.index();
  path_.at[i] = i;
  apart_[i] = seen == Seen::Apart;
  dimension_ = sampler.dimension();
}

// From pixels to rays: sample_camera() of render/camera_sample.h.
void PlainPaths::aim() {
  const Camera::Pinhole camera = scene_.camera.pinhole();
  for (uint32_t first = 0; first < count_; first += kDoubles) {
    Double4 u, v;
    sampler_of(first).next2(dimension_, u, v);
    const Double4 right = load4(origin_[0].at + first) + u - 0.5 * scene_.camera.width();
    const Double4 down = load4(origin_[1].at + first) + v - 0.5 * scene_.camera.height();
    const Vec3x4 direction = normalize(all(camera.forward) + all(camera.right) * right + all(camera.down) * down);
    const Double4 coordinates[]{direction.x, direction.y, direction.z};
    for (int c = 0; c < 3; ++c) {
      store4(origin_[c].at + first, all(camera.position[c]));
      store4(direction_[c].at + first, coordinates[c]);
    }
  }
  ++dimension_;
}

SamplerLanes<Uint4> PlainPaths::sampler_of(uint32_t first) const {
  return {load4(index_.at + first), load4(key_.at + first)};
}

void PlainPaths::trace(Tracing& tracing) {
  tracing.counts.camera += count_;
  if (by_pixels_) aim();
  for (int c = 0; c < 3; ++c) {
    std::fill_n(throughput_[c].at, count_, 1.0);
    std::fill_n(sum_[c].at, count_, 0.0);
  }
  std::fill_n(bsdf_pdf_.at, count_, 0.0);
  if (!plain_.chalk) {
    std::fill_n(scale_.at, count_, 1.0);
    std::fill_n(inside_.at, count_, 0);
    std::fill_n(taken_.at, count_, dimension_);
  }
  for (depth_ = 1; count_ > 0; ++depth_) {
    uint32_t to = 0;
    for (uint32_t first = 0; first < count_; first += kDoubles) {
      const uint32_t live = count_ - first >= kDoubles ? 15u : (1u << (count_ - first)) - 1;
      to = plain_.chalk ? segment<true>(first, to, live, tracing) : segment<false>(first, to, live, tracing);
    }
    count_ = to;
    dimension_ += (plain_.lamp ? 1 : 0) + 1 + (depth_ >= kRouletteDepth && scene_.roulette);
  }
}

void PlainPaths::end(uint32_t first, uint32_t ended, const Vec3x4& sum) {
  for (; ended; ended &= ended - 1) {
    const int lane = std::countr_zero(ended);
    radiance_[path_.at[first + lane]] = {sum.x[lane], sum.y[lane], sum.z[lane]};
  }
}

// What is seldom: these go on alone, from this segment on.
void PlainPaths::leave(uint32_t first, uint32_t seldom, Tracing& tracing) {
  for (; seldom; seldom &= seldom - 1) {
    const uint32_t i = first + std::countr_zero(seldom);
    auto vector = [i](const Lane (&lanes)[3]) { return Vec3(lanes[0].at[i], lanes[1].at[i], lanes[2].at[i]); };
    Media media;
    media.cross(*plain_.glass, true);
    Sampler sampler(index_.at[i], key_.at[i], taken_.at[i]);
    const PathState state{vector(sum_), vector(throughput_), scale_.at[i], bsdf_pdf_.at[i], {}, depth_};
    radiance_[path_.at[i]] = continue_path(scene_, {vector(origin_), vector(direction_)}, media, sampler, tracing,
                                           apart_[i] ? Seen::Apart : Seen::ByPath, state);
  }
}

// One segment of four paths from number `first` on, of which `live` has a bit each. Those that go on are written from
// number `to` on; returns where they end.
template <bool kChalk>
uint32_t PlainPaths::segment(uint32_t first, uint32_t to, uint32_t live, Tracing& tracing) {
  auto vector = [&](const Lane (&lanes)[3]) -> Vec3x4 {
    return {load4(lanes[0].at + first), load4(lanes[1].at + first), load4(lanes[2].at + first)};
  };
  auto numbers = [&](const Number& number) { return load4(number.at + first); };
  const Vec3x4 origin = vector(origin_), direction = vector(direction_);
  Vec3x4 throughput = vector(throughput_), sum = vector(sum_);
  const PlainHits hit = closest<kChalk>(plain_, origin, direction);
  const uint32_t missed = bits(hit.face) & live;  // -1 has the sign
  Mask4 inside{}, chalk = all(true);
  if constexpr (!kChalk) inside = widen(numbers(inside_));
  if (missed) {
    Vec3x4 beyond = sum;
    if (max_component(scene_.background) > 0.0 && built_with("background"))
      beyond = sum + throughput * all(scene_.background);
    end(first, missed, beyond);
    if constexpr (!kChalk) leave(first, missed & bits(inside > 0), tracing);
    live &= ~missed;
    if (!live) return to;
  }
  const PlainRows rows(plain_, hit.face);
  const PlainSurface surface = resolve<kChalk>(rows, origin, direction, hit);
  if constexpr (!kChalk) {
    chalk = ~(surface.mirror | surface.glass);
    // Where pieces of glass overlap, or anything else is met inside of one.
    const uint32_t seldom = bits((inside > 0) & ~(surface.glass & ~hit.entering)) & live;
    leave(first, seldom, tracing);
    live &= ~seldom;
    if (!live) return to;
    if (built_with("absorption") && plain_.glass && max_component(plain_.glass->absorption) > 0.0)
      for (uint32_t lanes = bits(inside > 0) & live; lanes; lanes &= lanes - 1) {
        const int lane = std::countr_zero(lanes);
        const Rgb left = transmittance(*plain_.glass, hit.t[lane]);
        throughput.x[lane] *= left[0], throughput.y[lane] *= left[1], throughput.z[lane] *= left[2];
      }
  }

  // --- What it sends by itself
  Double4 part[kDoubles];
  rows.look_up(offsetof(PlainScene::Face, emission), part);
  Mask4 counted = (part[3] > 0.0) & hit.entering;
  if (bits(counted) & live) {
    const Vec3x4 emission{part[0], part[1], part[2]};
    if (depth_ == 1)
      for (int lane = 0; lane < kDoubles; ++lane)
        if (apart_[first + lane]) counted[lane] = 0;
    const Double4 pdf = load4(bsdf_pdf_.at + first);
    const Mask4 sampled = (surface.area > 0.0) & (pdf > 0.0);
    Double4 weight = all(1.0);
    if (bits(sampled)) {
      const Double4 cosine = max(all(1e-300), dot(surface.outward, -direction));
      const double probability = plain_.lamp->probability;
      const Double4 light = probability * hit.t * hit.t / (cosine * surface.area);
      const Double4 other = usable(light) ? light : all(0.0);
      weight = sampled ? power_heuristic(pdf, other) : weight;
    }
    const Vec3x4 sent = sum + throughput * emission * weight;
    sum = select(counted, sent, sum);
  }
  if (depth_ == max_depth_) {
    end(first, live, sum);
    return to;
  }

  // --- What the lamp sends to it
  const BasisLanes basis(surface.up);
  const SamplerLanes<Uint4> sampler = sampler_of(first);
  auto dimension = [&] {
    if constexpr (kChalk) return dimension_;
    else return numbers(taken_);
  }();
  Double4 u, v;
  if (plain_.lamp && (kChalk || bits(chalk) & live)) {
    const PlainScene::Lamp& lamp = *plain_.lamp;
    sampler.next2(dimension, u, v);
    const Vec3x4 at = all(lamp.origin) + u * all(lamp.edge1) + v * all(lamp.edge2), towards = at - surface.point;
    const Double4 distance2 = dot(towards, towards);
    const Vec3x4 wi = towards / sqrt(distance2);
    const Double4 cosine = -dot(wi, all(lamp.normal));
    const Double4 pdf = lamp.probability * distance2 / (cosine * lamp.area);
    const Vec3x4 radiance{lamp.radiance.x / pdf, lamp.radiance.y / pdf, lamp.radiance.z / pdf};
    const Double4 here = dot(wi, basis.z), bsdf_pdf = max(all(0.0), here) * kInvPi;
    const Vec3x4 f = surface.colour * bsdf_pdf;
    const Mask4 lit = chalk & (distance2 > 0.0) & (cosine > 0.0) & usable(pdf) & (max_component(radiance) > 0.0) &
                      (max_component(f) > 0.0);
    if (const uint32_t asked = bits(lit) & live) {
      tracing.counts.shadow += std::popcount(asked);
      const Vec3x4 to_end = at + all(lamp.end), start = surface.spawn(to_end - surface.point);
      const Mask4 in_the_way = occluded<kChalk>(plain_, start, to_end - start, lit);
      const Vec3x4 comes = throughput * (f * radiance * power_heuristic(pdf, bsdf_pdf));
      sum = select(lit & ~in_the_way, sum + comes, sum);
    }
  }

  // --- On to the next
  Vec3x4 wi{};
  Double4 pdf{}, scale = all(1.0);
  if constexpr (kChalk) {
    if (plain_.lamp) ++dimension;
    sampler.next2(dimension++, u, v);
    wi = cosine_hemisphere(u, v);
    pdf = wi.z * kInvPi;
    throughput = throughput * surface.colour;
  } else {
    scale = load4(scale_.at + first);
    Vec3x4 wo = basis.to_local(-direction);
    wo.z = max(wo.z, all(1e-12));
    wi = {-wo.x, -wo.y, wo.z};  // a mirror's
    Vec3x4 weight = surface.colour;
    if (bits(surface.glass) & live) {
      const double ior = plain_.glass->ior;
      const Double4 eta = hit.entering ? all(ior) : all(1.0 / ior);
      const FresnelLanes<Double4> fresnel = fresnel_dielectric(wo.z, eta);
      const Mask4 split = surface.glass & ~fresnel.total, through = split & ~(sampler.next1(dimension) < fresnel.reflectance);
      dimension -= narrow(split);  // a mask's lanes are -1
      wi = select(through, {-wo.x / eta, -wo.y / eta, -fresnel.cos_transmitted}, wi);
      weight = select(surface.glass, select(through, surface.colour / (eta * eta), all(Vec3(1.0))), weight);
      scale = through ? scale * (eta * eta) : scale;
      inside = through ? (Mask4)(hit.entering & 1) : inside;
    }
    if (bits(chalk) & live) {
      if (plain_.lamp) dimension -= narrow(chalk);
      sampler.next2(dimension, u, v);
      dimension -= narrow(chalk);
      const Vec3x4 scattered = cosine_hemisphere(u, v);
      wi = select(chalk, scattered, wi);
      pdf = chalk ? scattered.z * kInvPi : pdf;
    }
    throughput = throughput * weight;
  }
  const Double4 strength = kChalk ? max_component(throughput) : max_component(throughput) * scale;
  Mask4 on = (~chalk | (wi.z > 0.0)) & (strength > 0.0);
  if (depth_ >= kRouletteDepth && scene_.roulette) {
    const Double4 survival = min(all(1.0), strength);
    on &= sampler.next1(dimension) < survival;
    dimension += 1;
    throughput = throughput / survival;
  }
  const uint32_t alive = bits(on) & live;
  end(first, live & ~alive, sum);
  if (!alive) return to;
  tracing.counts.bounce += std::popcount(alive);
  const Vec3x4 next = normalize(basis.to_world(wi)), start = surface.spawn(next);
  auto put = [&](Lane (&lanes)[3], const Vec3x4& value) {
    keep(lanes[0].at + to, value.x, alive);
    keep(lanes[1].at + to, value.y, alive);
    keep(lanes[2].at + to, value.z, alive);
  };
  const Uint4 path = numbers(path_);
  put(origin_, start);
  put(direction_, next);
  put(throughput_, throughput);
  put(sum_, sum);
  keep(bsdf_pdf_.at + to, pdf, alive);
  if constexpr (!kChalk) {
    keep(scale_.at + to, scale, alive);
    keep(inside_.at + to, narrow(inside), alive);
    keep(taken_.at + to, dimension, alive);
  }
  keep(key_.at + to, sampler.key(), alive);
  keep(index_.at + to, sampler.index(), alive);
  keep(path_.at + to, path, alive);
  return to + std::popcount(alive);
}

}  // namespace tilecast
