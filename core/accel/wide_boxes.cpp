// Folding by surface: of a node's children the largest is replaced by its own children as long as there is room (Wald,
// Benthin and Boulos, "Getting Rid of Packets", RT 2008, section 4).
#include "accel/wide_boxes.h"

namespace tilecast {

WideBoxes WideBoxes::fold(const Bvh& bvh, const std::vector<uint32_t>& order, std::span<const FrameBox> boxes) {
  const std::vector<Bvh::Node>& binary = bvh.nodes();
  struct Part {
    FrameBox box;
    uint32_t child;  // of the binary hierarchy, or kPrimitive | a primitive's number
  };
  WideBoxes out;
  std::vector<uint32_t> pending{0};  // [number of a wide node]: the binary node that it stands for
  for (size_t number = 0; number < pending.size(); ++number) {
    Part parts[kLanes];
    int count = 0;
    auto put = [&](uint32_t node, int at) {  // a node's children, the first at a given place; false where there is no room
      const Bvh::Node& n = binary[node];
      const int more = n.count > 0 ? static_cast<int>(n.count) : 2;
      if (count + more - (at < count) > kLanes) return false;
      for (int k = 0; k < more; ++k) {
        const uint32_t child = n.count > 0 ? order[n.first + k] : n.first + k;
        Part& part = parts[k == 0 ? at : count];
        if (k > 0 || at == count) ++count;
        part = n.count > 0 ? Part{boxes[child].intersected(n.box()), kPrimitive | child} : Part{binary[child].box(), child};
      }
      return true;
    };
    put(pending[number], 0);
    for (uint32_t closed = 0;;) {
      int largest = -1;
      float area = -1.0f;
      for (int k = 0; k < count; ++k)
        if (float a = parts[k].box.half_area(); a > area && !(parts[k].child & kPrimitive) && !(closed >> k & 1))
          largest = k, area = a;
      if (largest < 0) break;
      if (!put(parts[largest].child, largest)) closed |= 1u << largest;
    }
    Node node{};
    node.count = count;
    for (int k = 0; k < count; ++k) {
      node.boxes.set(k, parts[k].box);
      node.child[k] = parts[k].child;
      if (parts[k].child & kPrimitive) continue;
      node.child[k] = static_cast<uint32_t>(pending.size());
      pending.push_back(parts[k].child);
    }
    out.nodes_.push_back(node);
  }
  return out;
}

}  // namespace tilecast
