#include "accel/accelerator.h"

#include <chrono>
#include <numeric>

#include "base/error.h"

namespace tilecast {
namespace {
constexpr size_t kHandful = 4;  // fewer primitives than this need no hierarchy
}

Accelerator Accelerator::build(std::string_view kind, std::span<const FrameBox> boxes, float test_cost) {
  auto start = std::chrono::steady_clock::now();
  if (kind != "auto" && kind != "none" && kind != "bvh")
    throw Error("accelerator must be auto, none or bvh, got " + std::string(kind));
  if (boxes.size() > UINT32_MAX / 2) throw Error("more than 2^31 primitives in one object");
  if (kind == "auto") kind = boxes.size() <= kHandful ? "none" : "bvh";
  if (boxes.empty()) kind = "none";

  Accelerator out;
  if (kind == "bvh") {
    Bvh bvh = Bvh::build(boxes, test_cost, out.order_);
    out.stats_.nodes = bvh.nodes().size();
    out.stats_.bytes = bvh.nodes().size() * sizeof(Bvh::Node);
    out.structure_ = std::move(bvh);
  } else {
    out.order_.resize(boxes.size());
    std::iota(out.order_.begin(), out.order_.end(), 0u);
    out.structure_ = BruteForce{static_cast<uint32_t>(boxes.size())};
  }
  out.stats_.kind = kind;
  out.stats_.bytes += out.order_.size() * sizeof(uint32_t);
  out.stats_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return out;
}

}  // namespace tilecast
