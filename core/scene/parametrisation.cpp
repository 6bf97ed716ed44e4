#include "scene/parametrisation.h"

#include "base/elementary.h"

namespace tilecast {
namespace {

// u and its direction; v comes apart.
struct Longitude {
  double u;
  Vec3 du;
};
Longitude longitude(const Vec3& p) { return {0.5 + atan2_turns(p.x, p.z), Vec3(p.z, 0.0, -p.x)}; }

// The axes of a square on the side of a box that faces along an axis.
struct Upright {
  Vec3 u{0.0}, v{0.0};
};
Upright upright(int axis, double sign) {
  Upright out;
  switch (axis) {
    case 0: out.u.z = -sign, out.v.y = 1.0; break;
    case 1: out.u.x = 1.0, out.v.z = -sign; break;
    default: out.u.x = sign, out.v.y = 1.0; break;
  }
  return out;
}
Upright upright(const Vec3& normal) {  // of the side that it points to most
  const Vec3 n = glm::abs(normal);
  const int axis = n.x >= n.y && n.x >= n.z ? 0 : n.y >= n.z ? 1 : 2;
  return upright(axis, normal[axis] < 0.0 ? -1.0 : 1.0);
}

Parametrisation on_box(const Vec3& lo, const Vec3& hi, const Vec3& normal, const Vec3& p) {
  const auto [u, v] = upright(normal);
  const Vec3 unit = (p - lo) / (hi - lo) - 0.5;
  return {{0.5 + glm::dot(u, unit), 0.5 + glm::dot(v, unit)}, u, v};
}

// side: 1 seen from above, -1 from below.
Parametrisation on_disk(double radius, double side, const Vec3& p) {
  const auto [u, v] = upright(1, side);
  return {{0.5 + 0.5 * p.x / radius, 0.5 - side * 0.5 * p.z / radius}, u, v};
}

Parametrisation of(const Sphere&, int, const Vec3& p) {
  const auto [u, du] = longitude(p);
  return {{u, 1.0 - 2.0 * atan2_turns(std::sqrt(p.x * p.x + p.z * p.z), p.y)}, du};
}
Parametrisation of(const Block& b, int face, const Vec3& p) { return on_box(b.lo, b.hi, block_outward(face), p); }
Parametrisation of(const RoundedBlock& b, int face, const Vec3& p) { return on_box(b.lo, b.hi, outward(b, face, p), p); }
Parametrisation of(const Quadric& q, int face, const Vec3& p) { return on_box(q.lo, q.hi, outward(q, face, p), p); }
Parametrisation of(const Cylinder& c, int face, const Vec3& p) {
  if (face != 0) return on_disk(c.radius, face == 1 ? -1.0 : 1.0, p);
  const auto [u, du] = longitude(p);
  return {{u, 0.5 + p.y / c.height}, du};
}
Parametrisation of(const Cone& c, int face, const Vec3& p) {
  if (face != 0) return on_disk(face == 1 ? c.radius : c.top_radius, face == 1 ? -1.0 : 1.0, p);
  const auto [u, du] = longitude(p);
  return {{u, 0.5 + p.y / c.height}, du};
}
Parametrisation of(const Capsule& c, int, const Vec3& p) {
  const auto [u, du] = longitude(p);
  const double quarter = 0.5 * kPi * c.radius, whole = c.height + 2.0 * quarter;  // lengths from pole to pole
  const double y = std::clamp(p.y, -0.5 * c.height, 0.5 * c.height);
  const double latitude = 2.0 * kPi * atan2_turns(p.y - y, std::sqrt(p.x * p.x + p.z * p.z));
  return {{u, (quarter + 0.5 * c.height + y + c.radius * latitude) / whole}, du};
}
Parametrisation of(const Torus& t, int, const Vec3& p) {
  const auto [u, du] = longitude(p);
  return {{u, 0.5 + atan2_turns(p.y, std::sqrt(p.x * p.x + p.z * p.z) - t.radius)}, du};
}
Parametrisation of(const Halfspace& h, int face, const Vec3& p) {
  const Vec3 normal = outward(h, face, p), across = upright(normal).u;
  const Vec3 u = glm::normalize(across - glm::dot(across, normal) * normal), v = glm::cross(normal, u);
  return {{glm::dot(p, u), glm::dot(p, v)}, u, v};
}

}  // namespace

Parametrisation parametrisation(const Solid& solid, int face, const Vec3& p) {
  Parametrisation out = std::visit([&](const auto& s) { return of(s, face, p); }, solid);
  if (out.dv == Vec3(0.0)) out.dv = glm::cross(outward(solid, face, p), out.du);
  return out;
}

Parametrisation parametrisation(const Flat& flat, const Vec3& p) {
  if (const Disk* disk = std::get_if<Disk>(&flat)) return on_disk(disk->radius, 1.0, p);
  const Rectangle& r = std::get<Rectangle>(flat);
  return {{0.5 + p.x / r.width, 0.5 - p.z / r.depth}, {1.0, 0.0, 0.0}, {0.0, 0.0, -1.0}};
}

}  // namespace tilecast
