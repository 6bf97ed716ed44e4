#include "bind/bind.h"
#include "render/chunk.h"
#include "scene/queries.h"

using namespace tilecast;

namespace {

// What a chunk adds up to, as arrays.
struct Chunk {
  py::array sums;
  py::tuple rays;
};

Chunk chunk_of(const Scene& scene, int x, int y, int width, int height, uint32_t first, uint32_t count) {
  ChunkSums chunk;
  {
    py::gil_scoped_release release;
    chunk = render_chunk(scene, {x, y, width, height}, first, count);
  }
  return {to_array(std::move(chunk.sums), {2, height, width, 3}),
          py::make_tuple(chunk.rays.camera, chunk.rays.bounce, chunk.rays.shadow)};
}

std::span<const double> limits(const Array<double>& array, py::ssize_t count, const char* name) {
  if (array.ndim() > 0) check_shape(array, {count}, name);
  return {array.data(), static_cast<size_t>(array.size())};
}

// Runs a query over numpy's own memory with the GIL released.
template <class Query>
auto run(const Scene& scene, const Array<double>& origins, const Array<double>& directions, const Array<double>& t_min,
         const Array<double>& t_max, Query query) {
  check_shape(origins, {-1, 3}, "origins");
  py::ssize_t n = origins.shape(0);
  check_shape(directions, {n, 3}, "directions");
  RaySpan rays{{reinterpret_cast<const Vec3*>(origins.data()), size_t(n)},
               {reinterpret_cast<const Vec3*>(directions.data()), size_t(n)},
               limits(t_min, n, "t_min"), limits(t_max, n, "t_max")};
  py::gil_scoped_release release;
  return query(scene, rays);
}

template <class T>
py::array_t<T> column(std::vector<T>& values) {
  py::ssize_t n = static_cast<py::ssize_t>(values.size());
  return to_array(std::move(values), {n});
}

py::array as_bool(std::vector<uint8_t>& values) { return column(values).attr("view")("bool"); }

py::array triples(std::vector<Vec3>& values) {
  py::ssize_t n = static_cast<py::ssize_t>(values.size());
  auto* owner = new std::vector<Vec3>(std::move(values));
  py::capsule free(owner, [](void* p) { delete static_cast<std::vector<Vec3>*>(p); });
  return py::array_t<double>({n, py::ssize_t(3)}, reinterpret_cast<double*>(owner->data()), free);
}

struct Hits {
  py::array t, object, primitive, u, v, normal;
};

struct Runs {
  py::array offsets, t, object, primitive, entering;
};

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
  py::class_<Hits>(module, "Hits", "Closest hits, one entry a ray.")
      .def_readonly("t", &Hits::t, "[n] float64; infinity where nothing is hit")
      .def_readonly("object", &Hits::object, "[n] int64, index in the scene's list; -1: none")
      .def_readonly("primitive", &Hits::primitive, "[n] int64, number within the object")
      .def_readonly("u", &Hits::u, "[n] float64, weight of a triangle's second vertex")
      .def_readonly("v", &Hits::v, "[n] float64, weight of a triangle's third vertex")
      .def_readonly("normal", &Hits::normal, "[n, 3] float64, geometric, outward, unit length");
  py::class_<Runs>(module, "Crossings", "All crossings of whole lines, sorted along each.")
      .def_readonly("offsets", &Runs::offsets, "[n + 1] int64: line i owns offsets[i] to offsets[i + 1]")
      .def_readonly("t", &Runs::t)
      .def_readonly("object", &Runs::object)
      .def_readonly("primitive", &Runs::primitive)
      .def_readonly("entering", &Runs::entering, "bool: into the object");

  const Array<double> zero = py::cast(0.0), infinity = py::cast(kInfinity);
  py::class_<Scene, std::shared_ptr<Scene>>(module, "Scene", "An immutable scene. Tracing releases the GIL.")
      .def_property_readonly("width", [](const Scene& s) { return s.camera.width(); })
      .def_property_readonly("height", [](const Scene& s) { return s.camera.height(); })
      .def_property_readonly("primitives", [](const Scene& s) { return s.objects[s.root].primitives; },
                             "Primitives, instances multiplied out.")
      .def_property_readonly("bounds", &bounds_of,
                             "[2, 3] float64: the least and greatest corner, world space; a box around all objects, not the "
                             "smallest. None where there is nothing.")
      .def_readonly("features", &Scene::features, "What the scene uses, of FEATURES.")
      .def_property_readonly("kernel", &kernel_name)
      .def_property_readonly("accelerator", &accelerator_of, "kind, nodes, references, bytes and build seconds, all levels together; cost: expected, of the top level.")
      .def("render_chunk", &chunk_of, py::arg("x"), py::arg("y"), py::arg("width"), py::arg("height"), py::arg("first"),
           py::arg("count"), "Samples first .. first + count - 1 of the tile's pixels; (x, y): its top left pixel.")
      .def("closest",
           [](const Scene& s, const Array<double>& origins, const Array<double>& directions, const Array<double>& t_min,
              const Array<double>& t_max) {
             HitArrays h = run(s, origins, directions, t_min, t_max,
                               [](const Scene& scene, const RaySpan& rays) { return closest(scene, rays); });
             return Hits{column(h.t), column(h.object), column(h.primitive), column(h.u), column(h.v), triples(h.normal)};
           },
           py::arg("origins"), py::arg("directions"), py::arg("t_min") = zero, py::arg("t_max") = infinity,
           "The first hits in t_min < t <= t_max; origins, directions: [n, 3] float64.")
      .def("occluded",
           [](const Scene& s, const Array<double>& origins, const Array<double>& directions, const Array<double>& t_min,
              const Array<double>& t_max) {
             std::vector<uint8_t> dark = run(s, origins, directions, t_min, t_max,
                                             [](const Scene& scene, const RaySpan& rays) { return occluded(scene, rays); });
             return as_bool(dark);
           },
           py::arg("origins"), py::arg("directions"), py::arg("t_min") = zero, py::arg("t_max") = infinity,
           "[n] bool: whether anything is hit in t_min < t <= t_max.")
      .def("crossings",
           [zero, infinity](const Scene& s, const Array<double>& origins, const Array<double>& directions) {
             CrossingArrays c = run(s, origins, directions, zero, infinity,
                                    [](const Scene& scene, const RaySpan& rays) { return crossings(scene, rays); });
             return Runs{column(c.offsets), column(c.t), column(c.object), column(c.primitive), as_bool(c.entering)};
           },
           py::arg("origins"), py::arg("directions"), "All crossings of the whole lines, both ways.");
}
