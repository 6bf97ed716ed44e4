// Our kernels and Embree's on the same triangles and rays, in turns; medians and ratios.
//
//   trace_rays [--runs N] [--threads N] [--side N] [--only NAME] [--high-quality] [MESH.ply...]
//
// --high-quality: both by spatial splits.
#include <cstdio>
#include <functional>
#include <random>
#include <thread>

#include "accel/accelerated_mesh.h"
#include "accel/wide_trace.h"
#include "bench/clock.h"
#include "bench/embree.h"

namespace tilecast::bench {
namespace {

struct Options {
  int runs = 7;
  int threads = 1;
  uint32_t side = 1024;  // of the image, in pixels: a multiple of 16
  std::string only;
  bool high_quality = false;
};

double median(std::vector<double> v) {
  std::sort(v.begin(), v.end());
  return v[v.size() / 2];
}

// work(begin, end) over count items, in `threads` stretches.
void spread(int threads, size_t count, const std::function<void(size_t, size_t)>& work) {
  std::vector<std::thread> pool;
  for (int i = 1; i < threads; ++i) pool.emplace_back([&, i] { work(count * i / threads, count * (i + 1) / threads); });
  work(0, count / threads);
  for (std::thread& t : pool) t.join();
}

Vec3 rounded(const Vec3& v) { return {float(v.x), float(v.y), float(v.z)}; }

struct RaySets {
  std::vector<Ray> primary, diffuse, shadow;
};

// primary: a pinhole's, in tiles of 16 x 16, each in blocks of 4 x 4; shadow: from their hits, in the same order, to
// random points of a square light; diffuse: cosine-distributed from random ones of these hits.
RaySets make_rays(const Mesh& mesh, const AcceleratedMesh& accelerated, bool inside, uint32_t side) {
  RaySets out;
  std::mt19937 random(7);
  auto unit = [&] { return std::uniform_real_distribution<double>(0, 1)(random); };
  const Vec3 centre = mesh.bounds.centre(), half = mesh.bounds.hi - centre;
  const double radius = glm::length(half);
  const Vec3 eye = inside ? centre + 0.1 * half : centre + radius * Vec3(0.4, 0.9, 1.5);
  const Vec3 forward = glm::normalize(centre - eye), right = glm::normalize(glm::cross(forward, Vec3(0, 1, 0)));
  const Vec3 up = glm::cross(right, forward), light = centre + radius * Vec3(0.9, 2.0, 0.5);
  const double spread = inside ? 1.0 : 0.45;
  for (uint32_t i = 0; i < side * side; ++i) {
    auto bit = [&](int b) { return i >> b & 1; };
    uint32_t x = (bit(0) | bit(1) << 1 | bit(4) << 2 | bit(5) << 3) + 16 * (i / 256 % (side / 16));
    uint32_t y = (bit(2) | bit(3) << 1 | bit(6) << 2 | bit(7) << 3) + 16 * (i / 256 / (side / 16));
    Vec3 d = forward + spread * ((2.0 * (x + 0.5) / side - 1) * right + (1 - 2.0 * (y + 0.5) / side) * up);
    out.primary.push_back({rounded(eye), rounded(glm::normalize(d)), 0.0, kInfinity});
  }
  std::vector<FaceHit> hits(out.primary.size());
  accelerated.closest(out.primary, hits.data());
  std::vector<Ray> from;  // hit point, normal
  for (size_t i = 0; i < hits.size(); ++i) {
    if (hits[i].face == FaceHit::kNone) continue;
    Triangle t = mesh.triangle(hits[i].face);
    Vec3 normal = glm::normalize(glm::cross(Vec3(t.b) - Vec3(t.a), Vec3(t.c) - Vec3(t.a)));
    if (glm::dot(normal, out.primary[i].direction) > 0) normal = -normal;
    from.push_back({out.primary[i].at(hits[i].t) + 1e-5 * radius * normal, normal});
  }
  for (size_t i = 0; i < from.size(); ++i) {
    Vec3 target = light + 0.3 * radius * Vec3(unit() - 0.5, 0, unit() - 0.5);
    out.shadow.push_back({rounded(from[i].origin), rounded(target - from[i].origin), 0.0, 0.999});
  }
  for (size_t i = 0; i < side * side; ++i) {
    const Ray& at = from[random() % from.size()];
    double r = std::sqrt(unit()), phi = 2 * kPi * unit(), z = std::sqrt(1 - r * r);
    Vec3 a = glm::normalize(glm::cross(at.direction, std::fabs(at.direction.x) > 0.5 ? Vec3(0, 1, 0) : Vec3(1, 0, 0)));
    Vec3 b = glm::cross(at.direction, a);
    Vec3 d = r * std::cos(phi) * a + r * std::sin(phi) * b + z * at.direction;
    out.diffuse.push_back({rounded(at.origin), rounded(d), 0.0, kInfinity});
  }
  for (auto* set : {&out.primary, &out.diffuse, &out.shadow}) set->resize(set->size() / 16 * 16);
  return out;
}

void race(const Triangles& triangles, const Options& options) {
  Mesh mesh = Mesh::build(triangles.vertices, triangles.faces);
  AcceleratorChoice choice(options.high_quality ? "sbvh" : "bvh");
  choice.threads = options.threads;
  std::vector<double> ours_build, embree_build;
  for (int i = 0; i < std::min(options.runs, 3); ++i) {
    ours_build.push_back(seconds(options.threads, [&] { AcceleratedMesh(mesh, choice); }));
    embree_build.push_back(Embree(triangles, {.high_quality = options.high_quality, .threads = options.threads}).build_seconds());
  }
  AcceleratedMesh ours(mesh, choice);
  Embree embree(triangles, {.high_quality = options.high_quality, .threads = options.threads});
  Embree robust(triangles, {.robust = true, .high_quality = options.high_quality, .threads = options.threads});
  const double n = static_cast<double>(triangles.faces.size());
  std::printf("\n%s: %.0f triangles\n", triangles.name.c_str(), n);
  std::printf("  build       ours %.2f M/s, Embree %.2f M/s: ratio %.2f;  bytes a triangle: ours %.1f, Embree %.1f (peak %.1f)\n",
              n / median(ours_build) * 1e-6, n / median(embree_build) * 1e-6, median(embree_build) / median(ours_build),
              ours.bytes() / n, embree.bytes() / n, embree.peak_bytes() / n);
  RaySets sets = make_rays(mesh, ours, triangles.name == "soup", options.side);
  auto run = [&](const char* name, const std::vector<Ray>& rays, bool any, bool coherent) {
    if (!options.only.empty() && options.only != name) return;
    std::vector<FaceHit> hits(rays.size());
    std::vector<uint32_t> faces(rays.size());
    Embree::Single single, single_robust, single_before;
    Embree::Packets packets, packets_before;
    Embree::lay_out(rays, single_before);
    Embree::lay_out(rays, packets_before);
    std::vector<double> t_ours, t_single, t_robust, t_packets;
    for (int i = 0; i < options.runs; ++i) {
      double ours_sum = 0, single_sum = 0, robust_sum = 0, packets_sum = 0;
      // In turns by stretches of the rays: what slows the machine down slows all alike.
      constexpr size_t kStretch = 1 << 18;
      single_robust = single = single_before, packets = packets_before;
      for (size_t from = 0; from < rays.size(); from += kStretch) {
        const size_t to = std::min(rays.size(), from + kStretch);
        auto timed = [&](size_t unit, auto&& work) {
          return seconds(options.threads, [&] {
            spread(options.threads, (to - from) / unit, [&](size_t b, size_t e) { work(from / unit + b, from / unit + e); });
          });
        };
        ours_sum += timed(16, [&](size_t b, size_t e) {
          std::span<const Ray> part = std::span(rays).subspan(16 * b, 16 * (e - b));
          any ? ours.occluded(part, &faces[16 * b]) : ours.closest(part, &hits[16 * b]);
        });
        single_sum += timed(1, [&](size_t b, size_t e) { any ? embree.occluded(single, b, e) : embree.closest(single, b, e); });
        packets_sum += timed(16, [&](size_t b, size_t e) {
          any ? embree.occluded(packets, b, e, coherent) : embree.closest(packets, b, e, coherent);
        });
        robust_sum += timed(1, [&](size_t b, size_t e) {
          any ? robust.occluded(single_robust, b, e) : robust.closest(single_robust, b, e);
        });
      }
      t_ours.push_back(ours_sum), t_single.push_back(single_sum), t_robust.push_back(robust_sum), t_packets.push_back(packets_sum);
    }
    size_t differ = 0, found = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
      bool hit = any ? faces[i] != FaceHit::kNone : hits[i].face != FaceHit::kNone;
      found += hit;
      bool theirs = any ? single.rays[i].ray.tfar < 0 : single.rays[i].hit.geomID != RTC_INVALID_GEOMETRY_ID;
      differ += hit != theirs || (!any && hit && std::fabs(hits[i].t - single.rays[i].ray.tfar) > 1e-4 * hits[i].t);
    }
    auto rate = [&](const std::vector<double>& t) { return rays.size() / median(t) * 1e-6; };
    auto ratio = [&](const std::vector<double>& t) {
      std::vector<double> r;
      for (size_t i = 0; i < t.size(); ++i) r.push_back(t[i] / t_ours[i]);
      return median(r);
    };
    std::printf("  %-10s ours %6.2f M/s  Embree: single %6.2f (x%.2f)  robust %6.2f (x%.2f)  packets of 16 %6.2f (x%.2f)   "
                "%.1f%% hit, %zu differ\n",
                name, rate(t_ours), rate(t_single), ratio(t_single), rate(t_robust), ratio(t_robust), rate(t_packets),
                ratio(t_packets), 100.0 * found / rays.size(), differ);
    std::fflush(stdout);
  };
  run("primary", sets.primary, false, true);
  run("diffuse", sets.diffuse, false, false);
  run("shadow", sets.shadow, true, true);
}

}  // namespace
}  // namespace tilecast::bench

int main(int argc, char** argv) try {
  using namespace tilecast::bench;
  Options options;
  std::vector<std::string> meshes;
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    auto value = [&] { return i + 1 < argc ? std::string(argv[++i]) : throw std::runtime_error(name + " wants a value"); };
    auto number = [&](int least) {
      const std::string text = value();
      size_t read = 0;
      const int n = std::isdigit(static_cast<unsigned char>(text[0])) ? std::stoi(text, &read) : 0;
      if (read != text.size() || n < least) throw std::runtime_error(name + ": must be at least " + std::to_string(least) + ", got " + text);
      return n;
    };
    if (name == "--runs") options.runs = number(1);
    else if (name == "--threads") options.threads = number(1);
    else if (name == "--side") options.side = static_cast<uint32_t>(number(16)) / 16 * 16;
    else if (name == "--only") options.only = value();
    else if (name == "--high-quality") options.high_quality = true;
    else if (name.starts_with("--")) throw std::runtime_error("unknown option " + name);
    else meshes.push_back(name);
  }
  if (meshes.empty()) meshes = {"terrain", "soup"};
  for (const std::string& name : meshes)
    race(name == "terrain" ? terrain(1000) : name == "soup" ? soup(500000) : read_ply(name), options);
} catch (const std::exception& error) {
  std::fprintf(stderr, "trace_rays: %s\n", error.what());
  return 2;
}
