// From the number of a primitive back to the object that holds it.
#pragma once

#include "base/built.h"
#include "scene/scene.h"

namespace tilecast {

// None that the build leaves out.
inline Kind kind_of(const Object& object) {
  const Kind kind = object.kind;
  if ((kind == Kind::Solid && !built_with("solid")) || (kind == Kind::Mesh && !built_with("mesh")) ||
      (kind == Kind::Csg && !built_with("csg")) ||
      (kind == Kind::Flat && !built_with("rectangle") && !built_with("disk")))
    __builtin_unreachable();
  return kind;
}

// Goes down the groups from the root, and on through a CSG where kThroughCsg; enter(instance) for each one on the way.
// `primitive` becomes the number within the object that is returned.
template <bool kThroughCsg, class Enter>
const Object& descend(const Scene& scene, uint64_t& primitive, Enter&& enter) {
  const Object* object = &scene.objects[scene.root];
  while (kind_of(*object) == Kind::Group || (kThroughCsg && kind_of(*object) == Kind::Csg)) {
    const Assembly& assembly =
        kind_of(*object) == Kind::Group ? scene.groups[object->index] : scene.csgs[object->index].assembly;
    const uint32_t i = assembly.find(primitive);
    const Instance& instance = assembly.instances[i];
    primitive -= assembly.first_primitive[i];
    enter(instance);
    object = &scene.objects[instance.object];
  }
  return *object;
}

}  // namespace tilecast
