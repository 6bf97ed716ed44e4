// Gates 22, 23 and 24: instances that are ill-conditioned, singular or mirrored.
#include "scene/surface.h"
#include "stress/scenes.h"
#include "stress/stress.h"

namespace tilecast::stress {
namespace {

using Quad = __float128;
using Wide = long double;
using QuadVec = std::array<Quad, 3>;

// --- Gate 22: a sphere under 16 levels of maps, against the same maps multiplied and inverted in 113 bits. A ray's hit is
// reckoned in 64, by the nearest point to the centre: off by a few 2^-64 times the condition number, a thousandth of the gate.

struct QuadMap {
  Quad m[3][3];  // rows
  QuadVec offset;

  QuadVec vector(const QuadVec& v) const {
    QuadVec out{};
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) out[r] += m[r][c] * v[c];
    return out;
  }
};

QuadMap widen(const Affine& a) {
  QuadMap out;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) out.m[r][c] = a.linear[c][r];
    out.offset[r] = a.offset[r];
  }
  return out;
}

QuadMap operator*(const QuadMap& a, const QuadMap& b) {
  QuadMap out{};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c)
      for (int k = 0; k < 3; ++k) out.m[r][c] += a.m[r][k] * b.m[k][c];
  out.offset = a.vector(b.offset);
  for (int r = 0; r < 3; ++r) out.offset[r] += a.offset[r];
  return out;
}

QuadMap inverted(const QuadMap& a) {
  QuadMap out{};
  Quad determinant = 0;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) {
      int r1 = (c + 1) % 3, r2 = (c + 2) % 3, c1 = (r + 1) % 3, c2 = (r + 2) % 3;
      out.m[r][c] = a.m[r1][c1] * a.m[r2][c2] - a.m[r1][c2] * a.m[r2][c1];
    }
  for (int c = 0; c < 3; ++c) determinant += a.m[0][c] * out.m[c][0];
  for (auto& row : out.m)
    for (Quad& x : row) x /= determinant;
  return out;
}

// The largest singular value: 200 steps of the power method.
double norm(const QuadMap& a) {
  glm::dmat3 m;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) m[c][r] = static_cast<double>(a.m[r][c]);
  Vec3 v = glm::normalize(Vec3(1.0, 0.7, 0.4));
  for (int i = 0; i < 200; ++i) v = glm::normalize((m * v) * m);
  return glm::length(m * v);
}

struct Nest {
  std::shared_ptr<const Scene> scene;
  Affine to_world;  // in double: to aim by
  Wide to_local[3][3], centre[3];  // the centre in the world
  double condition, size;
};

const std::vector<Nest>& nests() {
  static const std::vector<Nest> all = [] {
    Random random(22);
    std::uniform_real_distribution<double> unit(-1, 1);
    std::vector<Nest> out;
    for (int i = 0; i < 64; ++i) {
      int levels = i % 4 == 0 ? 1 : 16;
      double each = std::pow(10.0, 8.0 * (i / 4 + 1) / 16 / levels);  // condition number of a level: 1e8 of all at most
      SceneBuilder builder;
      uint32_t object = builder.add_solid(Sphere{1.0});
      Affine total;
      QuadMap wide = widen(total);
      for (int level = 0; level < levels; ++level) {
        Vec3 s{1.0, std::pow(each, -0.5 * (unit(random) + 1.0)), 1.0 / each};
        Affine map = translate({unit(random), unit(random), unit(random)}) * rotate(3.0 * unit(random), random_direction(random)) *
                     scale(s * std::sqrt(each)) * rotate(3.0 * unit(random), random_direction(random));
        object = builder.add_group({{object, map}}, "auto");
        total = map * total;
        wide = widen(map) * wide;
      }
      Nest nest{builder.build(object, {}), total, {}, {}, 0.0, norm(wide)};
      QuadMap inverse = inverted(wide);
      nest.condition = nest.size * norm(inverse);
      for (int r = 0; r < 3; ++r) {
        nest.centre[r] = static_cast<Wide>(wide.offset[r]);
        for (int c = 0; c < 3; ++c) nest.to_local[r][c] = static_cast<Wide>(inverse.m[r][c]);
      }
      out.push_back(std::move(nest));
    }
    return out;
  }();
  return all;
}

// How far the hit is from where the exact ray meets the exact ellipsoid, over |o| + |t d|, which are added to reach it, in
// units of 16 u times the condition number; infinity where it is missed.
double nested_error(Random& random, uint64_t i) {
  const Nest& nest = nests()[i % nests().size()];
  std::uniform_real_distribution<double> unit(0, 1);
  Vec3 target = nest.to_world.point(0.5 * unit(random) * random_direction(random));
  Vec3 origin = target + nest.size * (2.0 + unit(random)) * random_direction(random);
  Ray ray{origin, target - origin};
  Hit hit = closest(*nest.scene, ray);
  if (!hit.found()) return kInfinity;

  Wide o[3] = {}, d[3] = {}, nearest[3];
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) {
      o[r] += nest.to_local[r][c] * (ray.origin[c] - nest.centre[c]);
      d[r] += nest.to_local[r][c] * ray.direction[c];
    }
  auto dot = [](const Wide a[3], const Wide b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
  Wide a = dot(d, d), t = -dot(o, d) / a;
  for (int k = 0; k < 3; ++k) nearest[k] = o[k] + t * d[k];
  t -= std::sqrt((1 - dot(nearest, nearest)) / a);

  Surface surface = resolve(*nest.scene, ray, hit);
  double error = 0.0, magnitude = glm::length(origin) + hit.t * glm::length(ray.direction);
  for (int k = 0; k < 3; ++k) {
    Wide exact = origin[k] + t * ray.direction[k], along = origin[k] + Wide(hit.t) * ray.direction[k];
    error = std::max({error, std::fabs(double(along - exact)), std::fabs(double(surface.point[k] - exact))});
  }
  return error / (16 * kUnitRoundoff * nest.condition * magnitude);
}

// --- Gate 23

// A map of rank 0, 1 or 2, up to rounding, or one that is not finite.
Affine singular(Random& random, uint64_t i) {
  std::uniform_real_distribution<double> unit(-1, 1);
  double size = std::ldexp(1.0, static_cast<int>(random() % 401) - 200);
  Affine flat = scale(Vec3(size));
  int axis = static_cast<int>(random() % 3);
  switch (i % 5) {
    case 0: flat.linear[axis] = Vec3(0.0); break;
    case 1: {  // a column that depends on the others
      flat = rotate(3.0 * unit(random), random_direction(random)) * flat;
      flat.linear[axis] = unit(random) * flat.linear[(axis + 1) % 3] + unit(random) * flat.linear[(axis + 2) % 3];
      break;
    }
    case 2: {  // turned, flattened, turned
      Vec3 s(1.0);
      s[axis] = 0.0;
      flat = rotate(3.0 * unit(random), random_direction(random)) * scale(size * s) *
             rotate(3.0 * unit(random), random_direction(random));
      break;
    }
    case 3: {  // rank 1
      Vec3 v = size * random_direction(random);
      for (int k = 0; k < 3; ++k) flat.linear[k] = unit(random) * v;
      break;
    }
    default: flat.linear[axis][random() % 3] = random() & 1 ? kInfinity : std::nan("");
  }
  return flat;
}

bool refusal_is_missing(Random& random, uint64_t i) {
  thread_local SceneBuilder builder;  // keeps nothing of what it refuses
  thread_local const uint32_t sphere = builder.add_solid(Sphere{1.0});
  size_t place = random() % 3;
  std::vector<InstanceSource> instances(3, {sphere, random_affine(random)});
  instances[place].transform = singular(random, i);
  try {
    if (random() & 1)
      builder.add_group(instances, "auto");
    else
      builder.add_csg(CsgOperation::Union, instances);
  } catch (const Error& error) {
    return std::string(error.what()).find("of[" + std::to_string(place) + "].transform: ") != 0;
  }
  return true;
}

// --- Gate 24: a mesh mirrored by its instance, and the same mesh mirrored beforehand.

struct Mirrored {
  std::shared_ptr<const Scene> instanced, beforehand;
  MeshSource mesh;  // that of `beforehand`
};

const std::vector<Mirrored>& mirrored() {
  static const std::vector<Mirrored> all = [] {
    std::vector<Mirrored> out;
    for (int signs = 1; signs < 8; ++signs)
      for (const MeshSource& source : {icosphere(2), torus(1.0, 0.4, 20, 12)}) {
        Vec3 mirror{signs & 1 ? -1.0 : 1.0, signs & 2 ? -0.5 : 0.5, signs & 4 ? -2.0 : 2.0};
        MeshSource moved = source;
        for (Vec3& v : moved.vertices) v *= mirror;
        if (mirror.x * mirror.y * mirror.z < 0.0)
          for (auto& f : moved.faces) std::swap(f.y, f.z);
        SceneBuilder a, b;
        uint32_t of_a = a.add_mesh(source.build(), "auto"), of_b = b.add_mesh(moved.build(), "auto");
        out.push_back({scene_of(a, {{of_a, scale(mirror)}}), scene_of(b, {{of_b, Affine{}}}), moved});
      }
    return out;
  }();
  return all;
}

// How far the ray passes from the nearest edge of the triangle.
double distance_from_edge(const MeshSource& mesh, const Ray& ray, uint32_t primitive) {
  const auto& face = mesh.faces[primitive];
  double least = kInfinity;
  for (int k = 0; k < 3; ++k) {
    const Vec3 &p = mesh.vertices[face[k]], &q = mesh.vertices[face[(k + 1) % 3]];
    Vec3 across = glm::cross(ray.direction, q - p);
    least = std::min(least, std::fabs(glm::dot(p - ray.origin, across)) / glm::length(across));
  }
  return least;
}

// Both are the same float mesh up to a power of two an axis, but rays are rounded in the frames of both, which moves them aside
// by a part of the float's unit roundoff of the coordinates. No more may lie between the hits, across the surface; and only
// where the ray passes so near an edge of the nearer triangle may the other mesh show what is beside or behind it.
bool mirror_shows(Random& random, uint64_t i) {
  const Mirrored& pair = mirrored()[i % mirrored().size()];
  Ray ray = random_ray(random, i & 1 ? 5.0 : 0.3);
  const double moved = 0x1p-24 * 5.0;
  Hit a = closest(*pair.instanced, ray), b = closest(*pair.beforehand, ray);
  if (a.primitive != b.primitive) return distance_from_edge(pair.mesh, ray, a.t < b.t ? a.primitive : b.primitive) > moved;
  if (!a.found()) return false;
  Surface of_a = resolve(*pair.instanced, ray, a), of_b = resolve(*pair.beforehand, ray, b);
  return a.entering != b.entering || max_abs(of_a.normal - of_b.normal) > 1e-6 ||
         std::fabs(glm::dot(of_a.point - of_b.point, of_b.normal)) > moved;
}

}  // namespace

void add_instances(std::vector<Case>& out) {
  out.push_back({"nested-instances", 22, "error of the hit, in 16 u times the condition number", 1, Combine::Max, 1'000'000,
                 1'000'000'000, worst_of(nested_error)});
  out.push_back({"singular-transforms", 23, "not refused by name", 0, Combine::Sum, 1'000'000, 10'000'000,
                 sum_of(refusal_is_missing)});
  out.push_back({"mirrored-instances", 24, "hits unlike those of the mesh mirrored beforehand", 0, Combine::Sum, 1'000'000,
                 1'000'000'000, sum_of(mirror_shows)});
}

}  // namespace tilecast::stress
