// What a scene is made of. Objects are named by their index in Scene::objects; shared ones are stored once.
//
// An object is a solid, a flat open surface, a mesh, a CSG of closed objects or a group of instances. Its primitives (faces of
// solids, triangles) are numbered through, instances multiplied out, in the order of the scene: that number names a
// hit, orders ties, and finds the way back to the instance without the traversal having to remember it.
#pragma once

#include <optional>
#include <vector>

#include "accel/accelerated_mesh.h"
#include "accel/wide_boxes.h"
#include "base/affine.h"
#include "geometry/flat.h"
#include "geometry/solid.h"
#include "scene/csg_filter.h"

namespace tilecast {

enum class Kind : uint8_t { Solid, Flat, Mesh, Csg, Group };

struct Object {
  Kind kind;
  uint32_t index;       // among the objects of its kind
  uint64_t primitives;  // instances multiplied out
  Box bounds;           // its own space, metres
};

inline constexpr int kInherit = -1;

// A reference and a matrix. The ray is taken into the object's space; t stays.
struct Instance {
  uint32_t object;
  int material;  // kInherit: that of the enclosing instance; the innermost given one wins
  Affine to_parent;
  InverseAffine to_local;
  bool turned = true;    // or scaled: otherwise it is only moved, which costs less
  double stretch = 1.0;  // of to_parent: an upper bound

  Ray local(const Ray& r) const {
    return turned ? to_local.ray(r) : Ray{r.origin - to_local.origin, r.direction, r.t_min, r.t_max};
  }
};

// Instances under an accelerator.
struct Assembly {
  std::vector<Instance> instances;
  std::vector<uint64_t> first_primitive;  // of each instance
  Frame frame;
  Accelerator accelerator;
  BoxLanes few;  // where there are at most kLanes instances, their boxes: looked at together, without the accelerator
  bool all_at_once = false;  // none is worth a box: each is visited
  std::optional<WideBoxes> wide;  // a group's bvh or sbvh, folded: instead of the accelerator
  Box bounds;

  static Assembly build(std::vector<Instance> instances, const std::vector<Object>& objects,
                        const AcceleratorChoice& choice, bool fold);
  uint64_t primitives(const std::vector<Object>& objects) const;
  // The instance that holds a primitive.
  uint32_t find(uint64_t primitive) const;
};

enum class CsgOperation : uint8_t { Union, Intersection, Difference };

// A tree of set operations, flattened. Operands are solids and meshes.
struct Csg {
  struct Node {
    CsgOperation operation;
    int parent;        // -1 at the root
    uint32_t children;
    bool first;        // the first child of its parent: what a difference subtracts from
  };
  struct Operand {
    int parent;
    bool first;
    bool inside_out;  // a mesh whose faces are wound clockwise
    double rounding;  // of a line that is brought into its space: relative to what is added up on the way
  };
  Assembly assembly;    // of the operands, under a bvh
  FrameBox result_box;  // in the assembly's frame: where the result can be
  std::vector<Operand> operands;
  std::vector<Node> nodes;
  CsgFilter filter;     // of solids alone; may be empty

  const Bvh& tree() const { return assembly.accelerator.hierarchy(); }
};

}  // namespace tilecast
