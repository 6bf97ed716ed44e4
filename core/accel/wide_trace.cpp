#include "accel/wide_trace.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/wide_trace.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "accel/ray_order.h"
#include "accel/wide_packet-inl.h"
#include "accel/wide_stream-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tilecast::HWY_NAMESPACE {

// Traces rays in the order given, or as they come. An answer is none, and then what query_of(answer) makes of it.
template <class Answer, class QueryOf>
HWY_INLINE void trace_batch(const WideBvh& bvh, bool from_memory, const Frame& frame, const Ray* rays, size_t count,
                            const uint32_t* order, Answer* answers, const Answer& none, QueryOf&& query_of) {
  constexpr size_t kSize = FrameRays::kSize;
  FrameRays lines;
  Stream stream;
  Answer found[kSize];
  const Ray* group[kSize];
  NoCost free;
  int passing_over = 0, passed_over = 0;  // groups of unlike rays come in rows
  auto index = [&](size_t i) { return order ? order[i] : i; };
  for (size_t i = 0; i < count; i += kSize) {
    const int n = static_cast<int>(std::min(kSize, count - i));
    for (int k = 0; k < n; ++k) group[k] = rays + index(i + k);
    enter_frame(frame, group, n, lines);
    for (size_t k = i + kSize; k < std::min(count, i + 2 * kSize); ++k) __builtin_prefetch(rays + index(k));
    std::fill_n(found, n, none);
    auto query = [&](int ray) { return query_of(found[ray]); };
    uint64_t left = 0;
    if (passing_over > 0) {
      --passing_over;
    } else {
      lines.inside = trace_group(bvh, from_memory, lines, stream, query);
      passing_over = passed_over = lines.inside ? std::min(2 * passed_over + 1, 15) : 0;
    }
    for (int begin = 0; lines.inside && begin < n; begin += FrameRays::kPacket)
      left |= trace_packet<FrameRays::kPacket>(bvh, from_memory, lines, begin, stream, query) << begin;
    if (left) left = stream.trace(bvh, from_memory, lines, left, query);
    for (; left; left &= left - 1) {
      const int ray = std::countr_zero(left);
      trace(bvh, lines, ray, query_of(found[ray]), free);
    }
    for (int k = 0; k < n; ++k) answers[index(i + k)] = found[k];
  }
}

void closest_batch(const WideBvh& bvh, bool from_memory, const Frame& frame, const Ray* rays, size_t count, const uint32_t* order,
                   FaceHit* hits) {
  trace_batch(bvh, from_memory, frame, rays, count, order, hits, FaceHit{}, [](FaceHit& best) { return Closest{best}; });
}
void occluded_batch(const WideBvh& bvh, bool from_memory, const Frame& frame, const Ray* rays, size_t count, const uint32_t* order,
                   uint32_t* faces) {
  trace_batch(bvh, from_memory, frame, rays, count, order, faces, FaceHit::kNone, [](uint32_t& face) { return Any{face}; });
}

template <class Query, class Cost>
HWY_INLINE void trace_one(const WideBvh& bvh, const Frame& frame, const Ray& ray, Query query, Cost& cost) {
  FrameRay line;
  if (!tilecast::enter_frame(frame, ray, line)) return;
  FrameRays lines(line, ray.t_min, ray.t_max);
  trace(bvh, lines, 0, query, cost);
}

void closest_one(const WideBvh& bvh, const Frame& frame, const Ray& ray, FaceHit& hit) {
  NoCost free;
  trace_one(bvh, frame, ray, Closest{hit}, free);
}
void closest_counted(const WideBvh& bvh, const Frame& frame, const Ray& ray, FaceHit& hit, TraversalCost& cost) {
  trace_one(bvh, frame, ray, Closest{hit}, cost);
}
void occluded_one(const WideBvh& bvh, const Frame& frame, const Ray& ray, uint32_t& face) {
  NoCost free;
  trace_one(bvh, frame, ray, Any{face}, free);
}
void all_hits(const WideBvh& bvh, const Frame& frame, const Ray& ray, std::vector<FaceHit>& hits) {
  NoCost free;
  trace_one(bvh, frame, ray, All{hits}, free);
}

}  // namespace tilecast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tilecast {

HWY_EXPORT(closest_batch);
HWY_EXPORT(occluded_batch);
HWY_EXPORT(closest_one);
HWY_EXPORT(closest_counted);
HWY_EXPORT(occluded_one);
HWY_EXPORT(all_hits);

namespace {

// Whether the cache keeps a hierarchy too badly. Putting rays in order took a fifth of the time of diffuse ones through
// 1 MB, and made up for it from 6 MB on (Zen 3, 512 KB and 32 MB).
bool from_memory(const WideBvh& bvh) { return bvh.bytes() > 6 << 20; }

std::vector<uint32_t> order_of(const WideBvh& bvh, const Frame& frame, std::span<const Ray> rays) {
  return from_memory(bvh) ? order_for_cache(frame, rays) : std::vector<uint32_t>();
}

}  // namespace

void closest(const WideBvh& bvh, const Frame& frame, std::span<const Ray> rays, FaceHit* hits) {
  const std::vector<uint32_t> order = order_of(bvh, frame, rays);
  HWY_DYNAMIC_DISPATCH(closest_batch)(bvh, from_memory(bvh), frame, rays.data(), rays.size(), order.empty() ? nullptr : order.data(), hits);
}
void occluded(const WideBvh& bvh, const Frame& frame, std::span<const Ray> rays, uint32_t* faces) {
  const std::vector<uint32_t> order = order_of(bvh, frame, rays);
  HWY_DYNAMIC_DISPATCH(occluded_batch)(bvh, from_memory(bvh), frame, rays.data(), rays.size(), order.empty() ? nullptr : order.data(), faces);
}
FaceHit closest(const WideBvh& bvh, const Frame& frame, const Ray& ray) {
  FaceHit hit;
  HWY_DYNAMIC_DISPATCH(closest_one)(bvh, frame, ray, hit);
  return hit;
}
FaceHit closest(const WideBvh& bvh, const Frame& frame, const Ray& ray, TraversalCost& cost) {
  FaceHit hit;
  HWY_DYNAMIC_DISPATCH(closest_counted)(bvh, frame, ray, hit, cost);
  return hit;
}
uint32_t occluded(const WideBvh& bvh, const Frame& frame, const Ray& ray) {
  uint32_t face = FaceHit::kNone;
  HWY_DYNAMIC_DISPATCH(occluded_one)(bvh, frame, ray, face);
  return face;
}
void all_hits(const WideBvh& bvh, const Frame& frame, const Ray& ray, std::vector<FaceHit>& hits) {
  HWY_DYNAMIC_DISPATCH(all_hits)(bvh, frame, ray, hits);
}

}  // namespace tilecast
#endif
