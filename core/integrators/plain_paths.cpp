#include "integrators/plain_paths.h"

#include <bit>
#include <cstddef>

#include "integrators/direct.h"
#include "integrators/plain_hits.h"
#include "integrators/roulette.h"

namespace tilecast {
namespace {

using Face = PlainScene::Face;

// A density that can be divided by: as in direct.cpp.
Mask4 usable(Double4 pdf) { return (pdf > 1e-150) & (pdf < 1e150); }

Double4 power_heuristic(Double4 a, Double4 b) {
  const Double4 ratio = b / a;
  return 1.0 / (1.0 + ratio * ratio);
}

struct Basis4 {
  Vec3x4 x, y, z;

  explicit Basis4(const Vec3x4& n) : z(n) {
    const Double4 sign = (Double4)(((Mask4)n.z & INT64_MIN) | (Mask4)all(1.0));
    const Double4 a = -1.0 / (sign + n.z), b = n.x * n.y * a;
    x = {1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x};
    y = {b, sign + n.y * n.y * a, -n.y};
  }
  Vec3x4 to_world(const Vec3x4& v) const { return v.x * x + v.y * y + v.z * z; }
};

// square_to_disk and cosine_hemisphere.
Vec3x4 cosine_hemisphere(Double4 u, Double4 v) {
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
  for (Number* numbers : {&key_, &index_, &path_}) std::fill(std::begin(numbers->at), std::end(numbers->at), 0);
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
  Uint4 key, index;
  std::memcpy(&key, key_.at + first, sizeof(key));
  std::memcpy(&index, index_.at + first, sizeof(index));
  return {index, key};
}

void PlainPaths::trace(RayCounts& counts) {
  counts.camera += count_;
  if (by_pixels_) aim();
  for (int c = 0; c < 3; ++c) {
    std::fill_n(throughput_[c].at, count_, 1.0);
    std::fill_n(sum_[c].at, count_, 0.0);
  }
  std::fill_n(bsdf_pdf_.at, count_, 0.0);
  const uint32_t taken = plain_.lamp ? 1 : 0;  // dimensions of a segment
  for (depth_ = 1; count_ > 0; ++depth_) {
    uint32_t to = 0;
    for (uint32_t first = 0; first < count_; first += kDoubles)
      to = segment(first, to, count_ - first >= kDoubles ? 15u : (1u << (count_ - first)) - 1, counts);
    count_ = to;
    dimension_ += taken + 1 + (depth_ >= kRouletteDepth && scene_.roulette);
  }
}

void PlainPaths::end(uint32_t first, uint32_t ended, const Vec3x4& sum) {
  for (; ended; ended &= ended - 1) {
    const int lane = std::countr_zero(ended);
    radiance_[path_.at[first + lane]] = {sum.x[lane], sum.y[lane], sum.z[lane]};
  }
}

// One segment of four paths from number `first` on, of which `live` has a bit each. Those that go on are written from
// number `to` on; returns where they end.
uint32_t PlainPaths::segment(uint32_t first, uint32_t to, uint32_t live, RayCounts& counts) {
  auto vector = [&](const Lane (&lanes)[3]) -> Vec3x4 {
    return {load4(lanes[0].at + first), load4(lanes[1].at + first), load4(lanes[2].at + first)};
  };
  const Vec3x4 origin = vector(origin_), direction = vector(direction_);
  Vec3x4 throughput = vector(throughput_), sum = vector(sum_);
  const PlainHits hit = closest(plain_, origin, direction);
  const uint32_t missed = bits(hit.face) & live;  // -1 has the sign
  if (missed) {
    Vec3x4 beyond = sum;
    if (max_component(scene_.background) > 0.0 && built_with("background"))
      beyond = sum + throughput * all(scene_.background);
    end(first, missed, beyond);
    live &= ~missed;
    if (!live) return to;
  }

  // --- What the hit means: resolve()
  const double* rows[kDoubles];
  for (int lane = 0; lane < kDoubles; ++lane)
    rows[lane] = reinterpret_cast<const double*>(plain_.faces.data() + std::max<int64_t>(hit.face[lane], 0));
  auto look_up = [&](size_t offset, Double4 (&out)[kDoubles]) { turn(rows, offset / sizeof(double), out); };
  Double4 part[kDoubles], in[3][kDoubles], across[kDoubles], plane[kDoubles], leaf[3], world[3];
  for (int i = 0; i < 3; ++i) look_up(offsetof(Face, to_local) + i * sizeof(Face::Row), in[i]);
  look_up(offsetof(Face, across), across);
  look_up(offsetof(Face, plane), plane);
  const Vec3x4 from{origin.x - in[0][3], origin.y - in[1][3], origin.z - in[2][3]};
  for (int i = 0; i < 3; ++i) {
    const Double4 o = fma(in[i][0], from.x, fma(in[i][1], from.y, in[i][2] * from.z));
    const Double4 d = fma(in[i][0], direction.x, fma(in[i][1], direction.y, in[i][2] * direction.z));
    leaf[i] = (Mask4)across[i] ? plane[i] : o + hit.t * d;
  }
  for (int i = 0; i < 3; ++i) {
    look_up(offsetof(Face, to_world) + i * sizeof(Face::Row), part);
    world[i] = fma(part[0], leaf[0], fma(part[1], leaf[1], fma(part[2], leaf[2], part[3])));
  }
  const Vec3x4 point{world[0], world[1], world[2]}, leaf_point{leaf[0], leaf[1], leaf[2]};
  Double4 normal_row[kDoubles], colour[kDoubles];
  look_up(offsetof(Face, normal), normal_row);
  look_up(offsetof(Face, reflectance), colour);
  const Vec3x4 reflectance{colour[0], colour[1], colour[2]};
  const Double4 leaf_size = max_abs(leaf_point);
  const Double4 error = normal_row[3] * (colour[3] * leaf_size + 16 * kUnitRoundoff * leaf_size) +
                        16 * kUnitRoundoff * (max_abs(point) + across[3]);
  Vec3x4 up{normal_row[0], normal_row[1], normal_row[2]};  // on the viewer's side
  const Mask4 behind = dot(up, direction) > 0.0;
  up = {behind ? -up.x : up.x, behind ? -up.y : up.y, behind ? -up.z : up.z};
  const Vec3x4 outward{hit.entering ? up.x : -up.x, hit.entering ? up.y : -up.y, hit.entering ? up.z : -up.z};
  auto spawn = [&](const Vec3x4& towards) {
    const Double4 side = dot(towards, outward) >= 0.0 ? error : -error;
    return point + side * outward;
  };

  // --- What it sends by itself
  look_up(offsetof(Face, emission), part);
  const uint32_t shining = bits((part[3] > 0.0) & hit.entering) & live;
  if (shining) {
    const Vec3x4 emission{part[0], part[1], part[2]};
    Mask4 counted = (part[3] > 0.0) & hit.entering;
    if (depth_ == 1)
      for (int lane = 0; lane < kDoubles; ++lane)
        if (apart_[first + lane]) counted[lane] = 0;
    const Double4 pdf = load4(bsdf_pdf_.at + first);
    const Mask4 sampled = (plane[3] > 0.0) & (pdf > 0.0);
    Double4 weight = all(1.0);
    if (bits(sampled)) {
      const Double4 cosine = max(all(1e-300), dot(outward, {-direction.x, -direction.y, -direction.z}));
      const double probability = plain_.lamp->probability;
      const Double4 light = probability * hit.t * hit.t / (cosine * plane[3]);
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
  const Basis4 basis(up);
  const SamplerLanes<Uint4> sampler = sampler_of(first);
  uint32_t dimension = dimension_;
  Double4 u, v;
  if (plain_.lamp) {
    const PlainScene::Lamp& lamp = *plain_.lamp;
    sampler.next2(dimension++, u, v);
    const Vec3x4 at = all(lamp.origin) + u * all(lamp.edge1) + v * all(lamp.edge2), towards = at - point;
    const Double4 distance2 = dot(towards, towards);
    const Vec3x4 wi = towards / sqrt(distance2);
    const Double4 cosine = -dot(wi, all(lamp.normal));
    const Double4 pdf = lamp.probability * distance2 / (cosine * lamp.area);
    const Vec3x4 radiance{lamp.radiance.x / pdf, lamp.radiance.y / pdf, lamp.radiance.z / pdf};
    const Double4 here = dot(wi, basis.z), bsdf_pdf = max(all(0.0), here) * kInvPi;
    const Vec3x4 f = reflectance * bsdf_pdf;
    const Mask4 lit = (distance2 > 0.0) & (cosine > 0.0) & usable(pdf) & (max_component(radiance) > 0.0) &
                      (max_component(f) > 0.0);
    if (const uint32_t asked = bits(lit) & live) {
      counts.shadow += std::popcount(asked);
      const Vec3x4 to_end = at + all(lamp.end), start = spawn(to_end - point);
      const Mask4 in_the_way = occluded(plain_, start, to_end - start, lit);
      const Vec3x4 comes = throughput * (f * radiance * power_heuristic(pdf, bsdf_pdf));
      sum = select(lit & ~in_the_way, sum + comes, sum);
    }
  }

  // --- On to the next
  sampler.next2(dimension++, u, v);
  const Vec3x4 wi = cosine_hemisphere(u, v);
  throughput = throughput * reflectance;
  const Double4 strength = max_component(throughput);
  Mask4 on = (wi.z > 0.0) & (strength > 0.0);
  if (depth_ >= kRouletteDepth && scene_.roulette) {
    const Double4 survival = min(all(1.0), strength);
    on &= sampler.next1(dimension++) < survival;
    throughput = throughput / survival;
  }
  const uint32_t alive = bits(on) & live;
  end(first, live & ~alive, sum);
  if (!alive) return to;
  counts.bounce += std::popcount(alive);
  const Vec3x4 next = normalize(basis.to_world(wi)), start = spawn(next);
  auto put = [&](Lane (&lanes)[3], const Vec3x4& value) {
    keep(lanes[0].at + to, value.x, alive);
    keep(lanes[1].at + to, value.y, alive);
    keep(lanes[2].at + to, value.z, alive);
  };
  put(origin_, start);
  put(direction_, next);
  put(throughput_, throughput);
  put(sum_, sum);
  keep(bsdf_pdf_.at + to, wi.z * kInvPi, alive);
  Uint4 path;
  std::memcpy(&path, path_.at + first, sizeof(path));
  keep(key_.at + to, sampler.key(), alive);
  keep(index_.at + to, sampler.index(), alive);
  keep(path_.at + to, path, alive);
  return to + std::popcount(alive);
}

}  // namespace tilecast
