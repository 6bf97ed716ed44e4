// Ray queries over numpy arrays.
#include "bind/bind.h"

#include <chrono>
#include <cstring>

#include "scene/queries.h"

using namespace tilecast;

namespace {

struct Hits {
  py::array t, object, primitive, u, v, normal;
};

struct Runs {
  py::array offsets, t, object, primitive, entering;
};

// Numbers as float64 in C order: numpy's own memory where they are that already, else a copy.
Array<double> numbers(const py::object& object, const char* name) {
  py::array given = py::array::ensure(object);
  if (!given || !std::strchr("fiub", given.dtype().kind()))
    throw py::type_error(std::string(name) + ": must be numbers, got " +
                         (given ? "an array of " + std::string(py::str(given.dtype()))
                                : "a " + std::string(Py_TYPE(object.ptr())->tp_name) + " that is no array"));
  return Array<double>(given);
}

// Ends a query by Ctrl-C: looks for signals ten times a second, which alone needs the GIL.
Pause look_for_signals() {
  using Clock = std::chrono::steady_clock;
  return [last = Clock::now()]() mutable {
    if (Clock::now() - last < std::chrono::milliseconds(100)) return;
    py::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    last = Clock::now();
  };
}

struct RayArrays {
  Array<double> origins, directions, t_min, t_max;

  RayArrays(const py::object& o, const py::object& d, const py::object& least, const py::object& most)
      : origins(numbers(o, "origins")), directions(numbers(d, "directions")), t_min(numbers(least, "t_min")),
        t_max(numbers(most, "t_max")) {
    check_shape(origins, {-1, 3}, "origins");
    check_shape(directions, {origins.shape(0), 3}, "directions");
    for (auto [limit, name] : {std::pair(&t_min, "t_min"), std::pair(&t_max, "t_max")})
      if (limit->ndim() > 0) check_shape(*limit, {origins.shape(0)}, name);
  }

  // Runs a query over numpy's own memory with the GIL released.
  template <class Query>
  auto run(const Scene& scene, Query query) const {
    size_t n = static_cast<size_t>(origins.shape(0));
    RaySpan rays{{reinterpret_cast<const Vec3*>(origins.data()), n},
                 {reinterpret_cast<const Vec3*>(directions.data()), n},
                 {t_min.data(), static_cast<size_t>(t_min.size())},
                 {t_max.data(), static_cast<size_t>(t_max.size())}};
    py::gil_scoped_release release;
    return query(scene, rays, look_for_signals());
  }
};

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

Hits closest_of(const Scene& scene, const py::object& origins, const py::object& directions, const py::object& t_min,
                const py::object& t_max) {
  HitArrays h = RayArrays(origins, directions, t_min, t_max).run(scene, [](auto&&... a) { return closest(a...); });
  return {column(h.t), column(h.object), column(h.primitive), column(h.u), column(h.v), triples(h.normal)};
}

py::array occluded_of(const Scene& scene, const py::object& origins, const py::object& directions,
                      const py::object& t_min, const py::object& t_max) {
  auto dark = RayArrays(origins, directions, t_min, t_max).run(scene, [](auto&&... a) { return occluded(a...); });
  return as_bool(dark);
}

Runs crossings_of(const Scene& scene, const py::object& origins, const py::object& directions) {
  RayArrays lines(origins, directions, py::float_(0.0), py::float_(kInfinity));
  CrossingArrays c = lines.run(scene, [](auto&&... a) { return crossings(a...); });
  return {column(c.offsets), column(c.t), column(c.object), column(c.primitive), as_bool(c.entering)};
}

constexpr const char* kClosest = R"(The first hit of each ray, in t_min < t <= t_max.

origins, directions: [n, 3], world space, metres. float64 in C order is read where it is; other numbers and lists are
copied. A direction may have any length from 2^-1000 to 2^1000: the hit lies at origin + t * direction. t_min, t_max: one
number, or one for each ray.

Returns Hits. A ray with another direction, or with NaN or infinity in it, hits nothing. The GIL is released; Ctrl-C
ends the call.)";

constexpr const char* kOccluded = R"(Whether each ray hits anything in t_min < t <= t_max: [n] bool.

Arguments as for `closest`, and faster than it. A shadow ray from p to q has the direction q - p and t_max 1.)";

constexpr const char* kCrossings = R"(Every crossing of each whole line origin + t * direction, t from -inf to inf.

Arguments as for `closest`. Returns Crossings, sorted by t along each line. A closed object is crossed an even number of
times, entered as often as left, through edges and vertices too.)";

}  // namespace

void bind_queries(py::module_& module, SceneClass& scene) {
  py::class_<Hits>(module, "Hits", "Closest hits, one entry a ray.")
      .def_readonly("t", &Hits::t, "[n] float64, in lengths of the direction; infinity where nothing is hit")
      .def_readonly("object", &Hits::object,
                    "[n] int64, index in the scene's list, area lights after the others; -1: none")
      .def_readonly("primitive", &Hits::primitive,
                    "[n] int64, number within that object: a mesh's face; counted through where it has parts; -1: none")
      .def_readonly("u", &Hits::u, "[n] float64, weight of a triangle's second vertex")
      .def_readonly("v", &Hits::v, "[n] float64, weight of a triangle's third vertex; the first has 1 - u - v")
      .def_readonly("normal", &Hits::normal,
                    "[n, 3] float64, world space: geometric, outward, length 1; zero where nothing is hit");
  py::class_<Runs>(module, "Crossings", "All crossings of whole lines, sorted along each.")
      .def_readonly("offsets", &Runs::offsets, "[n + 1] int64: line i owns entries offsets[i] to offsets[i + 1] - 1")
      .def_readonly("t", &Runs::t, "[m] float64, in lengths of the direction; negative behind the origin")
      .def_readonly("object", &Runs::object, "[m] int64, index in the scene's list, area lights after the others")
      .def_readonly("primitive", &Runs::primitive, "[m] int64, number within that object")
      .def_readonly("entering", &Runs::entering, "[m] bool: against the outward normal, into the object");

  const py::float_ zero(0.0), infinity(kInfinity);
  scene
      .def("closest", &closest_of, py::arg("origins"), py::arg("directions"), py::arg("t_min") = zero,
           py::arg("t_max") = infinity, kClosest)
      .def("occluded", &occluded_of, py::arg("origins"), py::arg("directions"), py::arg("t_min") = zero,
           py::arg("t_max") = infinity, kOccluded)
      .def("crossings", &crossings_of, py::arg("origins"), py::arg("directions"), kCrossings);
}
