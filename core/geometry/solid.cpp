#include "geometry/solid.h"

namespace tilecast {

void check(const Solid& solid) {
  std::visit([](const auto& s) { check(s); }, solid);
}
int crossings(const Solid& solid, const Ray& line, SolidCrossing out[kMaxSolidCrossings]) {
  return std::visit([&](const auto& s) { return write(inside(s, line), out); }, solid);
}
Vec3 outward(const Solid& solid, int face, const Vec3& p) {
  return std::visit([&](const auto& s) { return outward(s, face, p); }, solid);
}
Vec3 project(const Solid& solid, int face, const Vec3& p) {
  return std::visit([&](const auto& s) { return project(s, face, p); }, solid);
}
double projection_error(const Solid& solid, const Vec3& p) {
  double largest = max_abs(p);  // of what is added up on the way
  if (auto* torus = std::get_if<Torus>(&solid)) largest = std::max(largest, torus->radius);
  return 16 * kUnitRoundoff * largest;
}

Box bounds(const Solid& solid) {
  return std::visit([](const auto& s) { return bounds(s); }, solid);
}
int face_count(const Solid& solid) {
  return std::visit([](const auto& s) { return s.kFaces; }, solid);
}

}  // namespace tilecast
