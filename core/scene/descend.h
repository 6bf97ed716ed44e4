// From the number of a primitive back to the object that holds it.
#pragma once

#include "scene/scene.h"

namespace tilecast {

// Goes down the groups from the root, and on through a CSG where kThroughCsg; enter(instance) for each one on the way.
// `primitive` becomes the number within the object that is returned.
template <bool kThroughCsg, class Enter>
const Object& descend(const Scene& scene, uint64_t& primitive, Enter&& enter) {
  const Object* object = &scene.objects[scene.root];
  while (object->kind == Kind::Group || (kThroughCsg && object->kind == Kind::Csg)) {
    const Assembly& assembly =
        object->kind == Kind::Group ? scene.groups[object->index] : scene.csgs[object->index].assembly;
    const uint32_t i = assembly.find(primitive);
    const Instance& instance = assembly.instances[i];
    primitive -= assembly.first_primitive[i];
    enter(instance);
    object = &scene.objects[instance.object];
  }
  return *object;
}

}  // namespace tilecast
