#include "bind/bind.h"
#include "render/chunk.h"
#include "render/first_hits.h"

using namespace tilecast;

namespace {

// What a chunk adds up to, as arrays.
struct Chunk {
  py::array sums;
  py::tuple rays;
};

using Samples = std::tuple<int, int, int, int, uint32_t, uint32_t>;  // x, y, width, height, first, count

std::vector<Chunk> chunks_of(const Scene& scene, const std::vector<Samples>& wanted) {
  std::vector<ChunkSums> found;
  {
    py::gil_scoped_release release;
    for (const auto& [x, y, width, height, first, count] : wanted)
      found.push_back(render_chunk(scene, {x, y, width, height}, first, count));
  }
  std::vector<Chunk> out;
  for (size_t i = 0; i < found.size(); ++i)
    out.push_back({to_array(std::move(found[i].sums), {2, std::get<3>(wanted[i]), std::get<2>(wanted[i]), 3}),
                   py::make_tuple(found[i].rays.camera, found[i].rays.bounce, found[i].rays.shadow)});
  return out;
}

Chunk chunk_of(const Scene& scene, int x, int y, int width, int height, uint32_t first, uint32_t count) {
  return chunks_of(scene, {{x, y, width, height, first, count}})[0];
}

std::pair<uint64_t, uint64_t> camera_cost_of(const Scene& scene, int x, int y, int width, int height) {
  py::gil_scoped_release release;
  TraversalCost cost = camera_cost(scene, {x, y, width, height});
  return {cost.steps, cost.tests};
}

py::array first_hits_of(const Scene& scene, int x, int y, int width, int height, uint32_t samples) {
  std::vector<float> hits;
  {
    py::gil_scoped_release release;
    hits = first_hits(scene, {x, y, width, height}, samples);
  }
  return to_array(std::move(hits), {height, width, kFirstHitChannels});
}

py::object bounds_of(const Scene& scene) {
  const Box& box = scene.objects[scene.root].bounds;
  if (box.empty()) return py::none();
  return to_array(std::vector<double>{box.lo.x, box.lo.y, box.lo.z, box.hi.x, box.hi.y, box.hi.z}, {2, 3});
}

py::dict accelerator_of(const Scene& scene) {
  const AcceleratorStats& stats = scene.accelerator;
  py::dict out;
  out["kind"] = stats.kind;
  out["nodes"] = stats.nodes;
  out["references"] = stats.references;
  out["bytes"] = stats.bytes;
  out["seconds"] = stats.seconds;
  out["cost"] = stats.cost;
  return out;
}

}  // namespace

void bind_scene(py::module_& module) {
  module.attr("FEATURES") = all_features();

  py::class_<Chunk>(module, "ChunkSums", "What a chunk adds up to.")
      .def_readonly("sums", &Chunk::sums, "[2, h, w, 3] float64: linear RGB radiance, even and odd sample indices.")
      .def_readonly("rays", &Chunk::rays, "(camera, bounce, shadow)");

  SceneClass scene(module, "Scene", "An immutable scene. Tracing releases the GIL.");
  scene.def_property_readonly("width", [](const Scene& s) { return s.camera.width(); })
      .def_property_readonly("height", [](const Scene& s) { return s.camera.height(); })
      .def_property_readonly("primitives", [](const Scene& s) { return s.objects[s.root].primitives; },
                             "Primitives, instances multiplied out.")
      .def_property_readonly("bounds", &bounds_of,
                             "[2, 3] float64: the least and greatest corner of a box around all objects, world space; "
                             "not the smallest. None where there is nothing.")
      .def_readonly("features", &Scene::features, "What the scene uses, of FEATURES.")
      .def_property_readonly("kernel", &kernel_name)
      .def_property_readonly("accelerator", &accelerator_of, "kind, nodes, references, bytes and build seconds, all levels together; cost: expected steps and tests of a line.")
      .def("render_chunk", &chunk_of, py::arg("x"), py::arg("y"), py::arg("width"), py::arg("height"), py::arg("first"),
           py::arg("count"), "Samples first .. first + count - 1 of the tile's pixels; (x, y): its top left pixel.")
      .def("render_chunks", &chunks_of, py::arg("chunks"),
           "The same of several chunks, one after the other: (x, y, width, height, first, count) each. For short ones, "
           "which would wait for Python's lock as long as they take.")
      .def("first_hits", &first_hits_of, py::arg("x"), py::arg("y"), py::arg("width"), py::arg("height"), py::arg("samples"),
           "[h, w, 7] float32, what the camera sees first in each pixel of a tile, a mean over its first samples: albedo (red, "
           "green, blue), outward geometric normal (x, y, z: world space), distance in metres; 0 where nothing is hit.")
      .def("camera_cost", &camera_cost_of, py::arg("x"), py::arg("y"), py::arg("width"), py::arg("height"),
           "(steps through the accelerator, primitives tested) of a ray through the centre of each pixel of a tile.");
  bind_queries(module, scene);
}
