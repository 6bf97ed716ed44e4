#include "bench/embree.h"

#include <atomic>
#include <stdexcept>

#include "bench/clock.h"

namespace tilecast::bench {
namespace {

// Of the device that is being built: Embree tells of every allocation.
std::atomic<long long> used, most;

bool count_bytes(void*, ssize_t bytes, bool) {
  long long now = used += bytes, before = most;
  while (now > before && !most.compare_exchange_weak(before, now)) {}
  return true;
}

template <class R>
void set(R& ray, const Ray& from) {
  ray.org_x = float(from.origin.x), ray.org_y = float(from.origin.y), ray.org_z = float(from.origin.z);
  ray.dir_x = float(from.direction.x), ray.dir_y = float(from.direction.y), ray.dir_z = float(from.direction.z);
  ray.tnear = float(from.t_min), ray.tfar = float(from.t_max), ray.time = 0.0f, ray.mask = ~0u, ray.id = 0, ray.flags = 0;
}

RTCIntersectContext context(bool coherent) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  return context;
}

const auto all_valid = [] {
  struct alignas(64) {
    int lanes[16];
  } mask;
  std::fill_n(mask.lanes, 16, -1);
  return mask;
}();

}  // namespace

Embree::Embree(const Triangles& mesh, const Options& options) {
  device_ = rtcNewDevice(("threads=" + std::to_string(options.threads)).c_str());
  if (!device_) throw std::runtime_error("Embree does not start");
  rtcSetDeviceMemoryMonitorFunction(device_, count_bytes, nullptr);
  used = most = 0;
  scene_ = rtcNewScene(device_);
  rtcSetSceneBuildQuality(scene_, options.high_quality ? RTC_BUILD_QUALITY_HIGH : RTC_BUILD_QUALITY_MEDIUM);
  rtcSetSceneFlags(scene_, options.robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
  RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, mesh.vertices.size()));
  for (const Vec3& v : mesh.vertices)
    for (int i = 0; i < 3; ++i) *vertices++ = static_cast<float>(v[i]);
  auto* faces = static_cast<uint32_t*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, mesh.faces.size()));
  for (const glm::uvec3& f : mesh.faces)
    for (int i = 0; i < 3; ++i) *faces++ = f[i];
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene_, geometry);
  rtcReleaseGeometry(geometry);
  long long before = used;
  most = before;
  seconds_ = seconds(options.threads, [&] { rtcCommitScene(scene_); });
  bytes_ = used - before, peak_ = most - before;
}

Embree::~Embree() {
  rtcReleaseScene(scene_);
  rtcReleaseDevice(device_);
}

void Embree::lay_out(std::span<const Ray> rays, Single& out) {
  out.rays.resize(rays.size());
  for (size_t i = 0; i < rays.size(); ++i) {
    set(out.rays[i].ray, rays[i]);
    out.rays[i].hit.geomID = out.rays[i].hit.primID = RTC_INVALID_GEOMETRY_ID;
    out.rays[i].hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  }
}

void Embree::lay_out(std::span<const Ray> rays, Packets& out) {
  out.rays.resize(rays.size() / 16);
  for (size_t i = 0; i < out.rays.size() * 16; ++i) {
    RTCRayHit16& p = out.rays[i / 16];
    int k = i % 16;
    const Ray& r = rays[i];
    p.ray.org_x[k] = float(r.origin.x), p.ray.org_y[k] = float(r.origin.y), p.ray.org_z[k] = float(r.origin.z);
    p.ray.dir_x[k] = float(r.direction.x), p.ray.dir_y[k] = float(r.direction.y), p.ray.dir_z[k] = float(r.direction.z);
    p.ray.tnear[k] = float(r.t_min), p.ray.tfar[k] = float(r.t_max), p.ray.time[k] = 0.0f, p.ray.mask[k] = ~0u;
    p.ray.id[k] = 0, p.ray.flags[k] = 0;
    p.hit.geomID[k] = p.hit.primID[k] = p.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
  }
}

void Embree::closest(Single& rays, size_t begin, size_t end) const {
  RTCIntersectContext c = context(false);
  for (size_t i = begin; i < end; ++i) rtcIntersect1(scene_, &c, &rays.rays[i]);
}
void Embree::closest(Packets& rays, size_t begin, size_t end, bool coherent) const {
  RTCIntersectContext c = context(coherent);
  for (size_t i = begin; i < end; ++i) rtcIntersect16(all_valid.lanes, scene_, &c, &rays.rays[i]);
}
void Embree::occluded(Single& rays, size_t begin, size_t end) const {
  RTCIntersectContext c = context(false);
  for (size_t i = begin; i < end; ++i) rtcOccluded1(scene_, &c, &rays.rays[i].ray);
}
void Embree::occluded(Packets& rays, size_t begin, size_t end, bool coherent) const {
  RTCIntersectContext c = context(coherent);
  for (size_t i = begin; i < end; ++i) rtcOccluded16(all_valid.lanes, scene_, &c, &rays.rays[i].ray);
}

}  // namespace tilecast::bench
