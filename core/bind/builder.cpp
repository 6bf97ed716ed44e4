#include <optional>
#include <thread>

#include "bind/bind.h"
#include "base/elementary.h"
#include "scene/builder.h"
#include "scene/sky.h"

using namespace tilecast;

namespace {

MaterialKind material_kind(const std::string& name) {
  static const std::map<std::string, MaterialKind> kinds{
      {"diffuse", MaterialKind::Diffuse}, {"mirror", MaterialKind::Mirror},   {"conductor", MaterialKind::Conductor},
      {"dielectric", MaterialKind::Dielectric}, {"plastic", MaterialKind::Plastic}, {"phong", MaterialKind::Phong}};
  auto found = kinds.find(name);
  if (found == kinds.end()) throw Error("type: no material is called " + name);
  return found->second;
}

// The one of an enumeration that has this place in the list of their names.
template <class Enumeration, class Names>
Enumeration named(const Names& names, const std::string& name, const char* what) {
  const auto found = std::find(std::begin(names), std::end(names), name);
  if (found == std::end(names)) throw Error(std::string(what) + ": none is called " + name);
  return static_cast<Enumeration>(found - std::begin(names));
}

CsgOperation csg_operation(const std::string& name) {
  if (name == "union") return CsgOperation::Union;
  if (name == "intersection") return CsgOperation::Intersection;
  if (name == "difference") return CsgOperation::Difference;
  throw Error("type: no CSG operation is called " + name);
}

Environment to_environment(const Array<float>& pixels, double rotation) {
  check_shape(pixels, {-1, -1, 3}, "pixels");
  const Vec3f* first = reinterpret_cast<const Vec3f*>(pixels.data());
  std::vector<Vec3f> copy(first, first + pixels.shape(0) * pixels.shape(1));
  const int width = static_cast<int>(pixels.shape(1)), height = static_cast<int>(pixels.shape(0));
  py::gil_scoped_release release;
  return Environment(std::move(copy), width, height, rotation);
}

std::vector<InstanceSource> to_instances(const Array<int32_t>& objects, const Array<double>& matrices,
                                         const Array<int32_t>& materials) {
  py::ssize_t n = objects.size();
  check_shape(objects, {n}, "objects");
  check_shape(matrices, {n, 4, 4}, "matrices");
  check_shape(materials, {n}, "materials");
  std::vector<InstanceSource> out(n);
  for (py::ssize_t i = 0; i < n; ++i) {
    const double* m = matrices.data(i);
    if (m[12] != 0.0 || m[13] != 0.0 || m[14] != 0.0 || m[15] != 1.0)
      throw Error("of[" + std::to_string(i) + "].transform: the last row must be 0, 0, 0, 1");
    InstanceSource& instance = out[i];
    instance.object = static_cast<uint32_t>(objects.at(i));
    instance.material = materials.at(i);
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) instance.transform.linear[column][row] = m[4 * row + column];
      instance.transform.offset[row] = m[4 * row + 3];
    }
  }
  return out;
}

uint32_t add_mesh(SceneBuilder& builder, const Array<double>& vertices, const Array<uint32_t>& faces,
                  AcceleratorChoice accelerator, const std::optional<Array<float>>& uvs) {
  check_shape(vertices, {-1, 3}, "vertices");
  check_shape(faces, {-1, 3}, "faces");
  std::span<const Vec3> v(reinterpret_cast<const Vec3*>(vertices.data()), vertices.shape(0));
  std::span<const glm::uvec3> f(reinterpret_cast<const glm::uvec3*>(faces.data()), faces.shape(0));
  accelerator.threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  std::vector<FaceUvs> corners;
  if (uvs) {
    check_shape(*uvs, {faces.shape(0), 3, 2}, "uvs");
    const FaceUvs* first = reinterpret_cast<const FaceUvs*>(uvs->data());
    corners.assign(first, first + uvs->shape(0));
  }
  py::gil_scoped_release release;
  return builder.add_mesh(Mesh::build(v, f), accelerator, std::move(corners));
}

constexpr const char* kAxes[]{"x", "y", "z", "u", "v"};
constexpr const char *kWraps[]{"repeat", "mirror", "clamp"}, *kTexelFilters[]{"bilinear", "closest"};

int add_image_texture(SceneBuilder& builder, std::shared_ptr<Texels> texels, const std::string& wrap, const std::string& filter,
                      const std::array<double, 2>& tiling, const std::array<double, 2>& offset) {
  return builder.add_texture(ImageTexture(std::move(texels), named<Wrap>(kWraps, wrap, "wrap"),
                                          named<TexelFilter>(kTexelFilters, filter, "filter"), {tiling[0], tiling[1]},
                                          {offset[0], offset[1]}));
}

// Everything that a material may have, each where it is given.
Material material_of(MaterialKind kind, const py::kwargs& settings) {
  Material m{.kind = kind};
  for (auto [key, value] : settings) {
    const std::string name = py::cast<std::string>(key);
    auto colour = [&, value = value] { return to_vec(py::cast<Triple>(value)); };
    auto number = [&, value = value] { return py::cast<double>(value); };
    auto whole = [&, value = value] { return py::cast<int>(value); };
    if (name == "reflectance") m.reflectance = colour();
    else if (name == "texture") m.texture = whole();
    else if (name == "roughness") m.roughness = number();
    else if (name == "ior") m.ior = number();
    else if (name == "abbe") m.abbe = number();
    else if (name == "absorption") m.absorption = colour();
    else if (name == "emission") m.emission = colour();
    else if (name == "opacity") m.opacity = number();
    else if (name == "tint") m.tint = colour();
    else if (name == "priority") m.priority = whole();
    else if (name == "eta") m.eta = colour();
    else if (name == "k") m.k = colour();
    else if (name == "specular") m.specular = colour();
    else if (name == "exponent") m.exponent = number();
    else if (name == "roughness_texture") m.roughness_texture = whole();
    else if (name == "opacity_texture") m.opacity_texture = whole();
    else if (name == "emission_texture") m.emission_texture = whole();
    else if (name == "normal_map") m.normal_map = whole();
    else throw py::type_error("material() has no setting " + name);
  }
  return m;
}

int add_blend(SceneBuilder& builder, const std::vector<int>& parts, const std::vector<double>& shares,
              const py::kwargs& settings) {
  Material m = material_of(MaterialKind::Blend, settings);
  if (parts.size() != shares.size() || parts.size() > Material::kMostParts)
    throw Error("of: a blend takes at most " + std::to_string(Material::kMostParts) + " materials, each with its share");
  std::copy(parts.begin(), parts.end(), m.parts);
  std::copy(shares.begin(), shares.end(), m.shares);
  return builder.add_material(m);
}

}  // namespace

void bind_builder(py::module_& module) {
  module.attr("ACCELERATORS") = accelerator_kinds();
  module.attr("GROUPINGS") = grouping_names();
  module.attr("FILTERS") = std::vector<std::string>(std::begin(kFilterNames), std::end(kFilterNames));
  module.attr("INTEGRATORS") = std::vector<std::string>(std::begin(kIntegratorNames), std::end(kIntegratorNames));
  py::class_<AcceleratorChoice>(module, "Accelerator", "Which accelerator, and how a bvh is built.")
      .def(py::init([](const std::string& kind, const std::string& grouping, bool reinsertion) {
             AcceleratorChoice choice(kind);
             choice.grouping = grouping;
             choice.reinsertion = reinsertion;
             choice.check();
             return choice;
           }), py::arg("kind") = "auto", py::arg("grouping") = "sah", py::arg("reinsertion") = false);
  py::implicitly_convertible<std::string, AcceleratorChoice>();
  using Instances = const Array<int32_t>&;
  using Matrices = const Array<double>&;
  py::class_<Texels, std::shared_ptr<Texels>>(module, "Texels", "What textures may share: `tilecast._images.texels` makes it.");
  py::class_<SceneBuilder>(module, "SceneBuilder", "Builds a Scene. Handles are ints; lengths metres, colours linear RGB.")
      .def(py::init<>())
      .def("checker", [](SceneBuilder& b, const Triple& even, const Triple& odd, double size, bool of_uv) {
            return b.add_texture(Checker{to_vec(even), to_vec(odd), size, of_uv});
          }, py::arg("even"), py::arg("odd"), py::arg("size"), py::arg("of_uv") = false,
          "Cubes in object space, or squares of the texture coordinates.")
      .def("gradient", [](SceneBuilder& b, const Triple& from, const Triple& to, const std::string& along, double start, double end) {
            return b.add_texture(Gradient{to_vec(from), to_vec(to), named<int>(kAxes, along, "along"), start, end});
          }, py::arg("from"), py::arg("to"), py::arg("along"), py::arg("start"), py::arg("end"), "along: x, y, z, u or v.")
      .def("image_texture", &add_image_texture, py::arg("texels"), py::arg("wrap"), py::arg("filter"), py::arg("tiling"),
           py::arg("offset"), "wrap: repeat, mirror or clamp; filter: bilinear or closest; the image at tiling * uv + offset.")
      .def("material", [](SceneBuilder& b, const std::string& kind, const py::kwargs& settings) {
            return b.add_material(material_of(material_kind(kind), settings));
          }, py::arg("kind"),
           "kind: diffuse, mirror, conductor, dielectric, plastic or phong; keywords: reflectance, texture, roughness, ior, "
           "absorption (per metre), emission (radiance), opacity, tint, priority, eta and k (a conductor's), specular and "
           "exponent (phong), roughness_texture, opacity_texture, emission_texture, normal_map.")
      .def("blend", &add_blend, py::arg("parts"), py::arg("shares"),
           "Up to three materials, each with its share of the light; keywords: emission, opacity, their textures, normal_map.")
      .def("sphere", [](SceneBuilder& b, double radius) { return b.add_solid(Sphere{radius}); }, py::arg("radius"))
      .def("box", [](SceneBuilder& b, const Triple& min, const Triple& max) {
            return b.add_solid(Block{to_vec(min), to_vec(max)});
          }, py::arg("min"), py::arg("max"))
      .def("cylinder", [](SceneBuilder& b, double radius, double height) { return b.add_solid(Cylinder{radius, height}); },
           py::arg("radius"), py::arg("height"), "About y, centred, closed.")
      .def("cone", [](SceneBuilder& b, double radius, double top_radius, double height) {
            return b.add_solid(Cone{radius, top_radius, height});
          }, py::arg("radius"), py::arg("top_radius"), py::arg("height"), "About y, centred, closed; radius: of the bottom.")
      .def("capsule", [](SceneBuilder& b, double radius, double height) { return b.add_solid(Capsule{radius, height}); },
           py::arg("radius"), py::arg("height"), "About y, centred; height: of the cylindrical part.")
      .def("torus", [](SceneBuilder& b, double radius, double minor_radius) { return b.add_solid(Torus{radius, minor_radius}); },
           py::arg("radius"), py::arg("minor_radius"), "About y; minor_radius: of the tube.")
      .def("rounded_box", [](SceneBuilder& b, const Triple& min, const Triple& max, double radius) {
            return b.add_solid(RoundedBlock{to_vec(min), to_vec(max), radius});
          }, py::arg("min"), py::arg("max"), py::arg("radius"))
      .def("quadric", [](SceneBuilder& b, const std::array<double, 10>& coefficients, const Triple& min, const Triple& max) {
            return b.add_solid(Quadric::of(coefficients, to_vec(min), to_vec(max)));
          }, py::arg("coefficients"), py::arg("min"), py::arg("max"),
          "Where the polynomial of x^2, y^2, z^2, xy, xz, yz, x, y, z and 1 is negative, within the box.")
      .def("halfspace", [](SceneBuilder& b, const Triple& normal, double offset) {
            return b.add_solid(Halfspace::of(to_vec(normal), offset));
          }, py::arg("normal"), py::arg("offset"), "Below the plane at `offset` along the normal. For CSG alone.")
      .def("rectangle", &SceneBuilder::add_rectangle, py::arg("width"), py::arg("depth"), "Open; in the xz plane, facing +y.")
      .def("disk", [](SceneBuilder& b, double radius) { return b.add_flat(Disk{radius}); }, py::arg("radius"),
           "Open; in the xz plane, facing +y.")
      .def("mesh", &add_mesh, py::arg("vertices"), py::arg("faces"), py::arg("accelerator") = AcceleratorChoice(),
           py::arg("uvs") = py::none(),
           "vertices: float64 [n, 3]; faces: uint32 [m, 3], counter-clockwise from outside; uvs: float32 [m, 3, 2], of the "
           "faces' corners.")
      .def("without_uvs", &SceneBuilder::without_uvs, py::arg("root"),
           "The meshes under an object that have no texture coordinates, although their material asks for some.")
      .def("csg", [](SceneBuilder& b, const std::string& operation, Instances objects, Matrices matrices, Instances materials) {
            return b.add_csg(csg_operation(operation), to_instances(objects, matrices, materials));
          }, py::arg("operation"), py::arg("objects"), py::arg("matrices"), py::arg("materials"),
          "union, intersection or difference of closed objects. objects, materials: int32 [n] (-1: inherit); matrices: [n, 4, 4].")
      .def("group", [](SceneBuilder& b, Instances objects, Matrices matrices, Instances materials,
                       const AcceleratorChoice& accelerator) {
            std::vector<InstanceSource> instances = to_instances(objects, matrices, materials);
            py::gil_scoped_release release;
            return b.add_group(instances, accelerator);
          }, py::arg("objects"), py::arg("matrices"), py::arg("materials"), py::arg("accelerator") = AcceleratorChoice(),
          "Instances; arrays as for csg. The innermost given material wins.")
      .def("point_light", [](SceneBuilder& b, const Triple& position, const Triple& intensity) {
            b.add_point_light({to_vec(position), to_vec(intensity)});
          }, py::arg("position"), py::arg("intensity"), "intensity: radiant intensity, W/sr.")
      .def("background", [](SceneBuilder& b, const Triple& radiance) { b.set_background(to_vec(radiance)); }, py::arg("radiance"))
      .def("spot_light", [](SceneBuilder& b, const Triple& position, const Triple& direction, const Triple& intensity,
                            double inner_angle, double outer_angle) {
            b.add_spot_light({to_vec(position), to_vec(direction), to_vec(intensity), cos_2pi(inner_angle / 360.0), cos_2pi(outer_angle / 360.0)});
          }, py::arg("position"), py::arg("direction"), py::arg("intensity"), py::arg("inner_angle"), py::arg("outer_angle"),
          "intensity: W/sr along the axis; angles: degrees from the axis, where it begins to fall and where it is 0.")
      .def("directional_light", [](SceneBuilder& b, const Triple& direction, const Triple& irradiance) {
            b.add_directional_light({to_vec(direction), to_vec(irradiance)});
          }, py::arg("direction"), py::arg("irradiance"), "direction: in which the light goes; irradiance: W/m^2, met head on.")
      .def("environment", [](SceneBuilder& b, const Array<float>& pixels, double rotation) {
            b.set_environment(to_environment(pixels, rotation));
          }, py::arg("pixels"), py::arg("rotation") = 0.0,
          "pixels: float32 [h, w, 3], radiance, equirectangular, +y at the top, -z in the middle; rotation: degrees about +y.")
      .def("sky", [](SceneBuilder& b, const Triple& sun, double turbidity, const Triple& ground, double scale) {
            b.set_environment(make_environment(Sky{to_vec(sun), turbidity, to_vec(ground), scale}));
          }, py::arg("sun_direction"), py::arg("turbidity"), py::arg("ground"), py::arg("scale"), "Clear, by day, without the sun itself.")
      .def("camera", &SceneBuilder::set_camera, py::arg("camera"))
      .def("filter", [](SceneBuilder& b, const std::string& name) { b.set_filter(named<PixelFilter::Kind>(kFilterNames, name, "filter")); },
           py::arg("name"), "One of FILTERS.")
      .def("build", [](SceneBuilder& b, uint32_t root, const std::string& integrator, int max_depth, uint32_t seed, bool next_event,
                       double ao_distance, const std::string& sampler, bool roulette, double contrast) {
            SceneBuilder::Options options{named<Integrator>(kIntegratorNames, integrator, "integrator"), max_depth, seed, next_event,
                                          ao_distance, named<Sampling>(kSamplingNames, sampler, "sampler"), roulette, contrast};
            py::gil_scoped_release release;
            return std::const_pointer_cast<Scene>(b.build(root, options));
          }, py::arg("root"), py::kw_only(), py::arg("integrator") = "path", py::arg("max_depth") = 8, py::arg("seed") = 0,
          py::arg("next_event") = true, py::arg("ao_distance") = kInfinity, py::arg("sampler") = "sobol",
          py::arg("roulette") = true, py::arg("contrast") = 0.0, "The finished scene. The builder is empty afterwards.");
}
