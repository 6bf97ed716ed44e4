#include "scene/light.h"

#include <algorithm>

#include "base/elementary.h"

namespace tilecast {

void Lights::finish() {
  std::sort(areas.begin(), areas.end(),
            [](const AreaLight& a, const AreaLight& b) { return a.first_primitive < b.first_primitive; });
  cumulative.clear();
  double sum = 0.0;
  for (const PointLight& p : points) cumulative.push_back(sum += 4.0 * kPi * max_component(p.intensity));
  for (const AreaLight& a : areas) cumulative.push_back(sum += kPi * a.area() * max_component(a.radiance));
}

double Lights::probability(size_t light) const {
  return (cumulative[light] - (light == 0 ? 0.0 : cumulative[light - 1])) / cumulative.back();
}

size_t Lights::choose(double u) const {
  auto found = std::upper_bound(cumulative.begin(), cumulative.end(), u * cumulative.back());
  return std::min<size_t>(found - cumulative.begin(), count() - 1);
}

int Lights::find(uint64_t primitive) const {
  auto next = std::upper_bound(areas.begin(), areas.end(), primitive,
                               [](uint64_t p, const AreaLight& a) { return p < a.first_primitive; });
  if (next == areas.begin()) return -1;
  --next;
  return primitive - next->first_primitive < next->primitives ? static_cast<int>(next - areas.begin()) : -1;
}

LightSample sample(const AreaLight& light, double u_piece, const Vec2& u) {
  size_t i = 0;
  if (light.pieces.size() > 1) {
    auto found = std::upper_bound(light.cumulative.begin(), light.cumulative.end(), u_piece * light.area());
    i = std::min<size_t>(found - light.cumulative.begin(), light.pieces.size() - 1);
  }
  const AreaLight::Piece& piece = light.pieces[i];
  double a = u.x, b = u.y;
  if (light.shape == AreaLight::Shape::Triangle) {  // Heitz, "A Low-Distortion Map Between Triangle and Square", 2019
    if (b > a) {
      a *= 0.5;
      b -= a;
    } else {
      b *= 0.5;
      a -= b;
    }
  }
  if (light.shape == AreaLight::Shape::Ellipse) {  // the affine image of a disk, uniform in the squared radius
    double sine, cosine, r = std::sqrt(u.x);
    sincos_2pi(u.y, sine, cosine);
    a = r * cosine;
    b = r * sine;
  }
  LightSample out;
  out.point = piece.origin + a * piece.edge1 + b * piece.edge2;
  out.normal = light.flip * glm::normalize(glm::cross(piece.edge1, piece.edge2));
  out.radiance = light.radiance;
  out.error = 32 * kUnitRoundoff * (max_abs(piece.origin) + max_abs(piece.edge1) + max_abs(piece.edge2));
  return out;
}

}  // namespace tilecast
