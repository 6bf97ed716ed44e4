#include "scene/light.h"

#include <algorithm>

#include "base/built.h"
#include "base/elementary.h"

namespace tilecast {
namespace {

constexpr size_t kManyLights = 5;  // at places: from here on a tree pays
constexpr double kLeastShare = 0x1p-20;  // of all power, for any light: no rounding leaves one out

// The most that an area light sends in one direction, over its radiance: its area as seen from there. Of a closed convex
// shape that is a quarter of its surface (Cauchy), which stands for what shines all around.
double seen_area(const AreaLight& light, bool all_around) { return (all_around ? 0.25 : 1.0) * light.area(); }

double power(const SpotLight& spot) {  // the smooth edge counts by half
  return 2.0 * kPi * max_component(spot.intensity) * (1.0 - 0.5 * (spot.cos_inner + spot.cos_outer));
}

}  // namespace

LightBounds AreaLight::bounds() const {
  LightBounds out;
  if (shape == Shape::Ball) {
    out.box = {pieces[0].origin - radius(), pieces[0].origin + radius()};
    out.intensity = max_component(radiance) * seen_area(*this, true);
    return out;
  }
  bool first = true;
  for (const Piece& piece : pieces) {
    const Vec3 far = piece.origin + piece.edge1 + piece.edge2;
    if (shape == Shape::Ellipse) {
      const Vec3 reach = glm::sqrt(piece.edge1 * piece.edge1 + piece.edge2 * piece.edge2);
      out.box.extend(Box{piece.origin - reach, piece.origin + reach});
    } else {
      out.box.extend(piece.origin);
      out.box.extend(piece.origin + piece.edge1);
      out.box.extend(piece.origin + piece.edge2);
      if (shape == Shape::Parallelogram) out.box.extend(far);
    }
    const Vec3 normal = flip * glm::cross(piece.edge1, piece.edge2);
    const double length = glm::length(normal);
    if (!(length > 0.0)) continue;
    if (first) out.axis = normal / length, out.normals = 0.0;
    first = false;
    out.normals = std::min(0.5, std::max(out.normals, turns_between(out.axis, normal) + 1e-12));
  }
  out.intensity = max_component(radiance) * seen_area(*this, out.normals > 0.25);
  return out;
}

void Lights::finish() {
  std::sort(areas.begin(), areas.end(),
            [](const AreaLight& a, const AreaLight& b) { return a.first_primitive < b.first_primitive; });
  count_ = environment_number() + (environment != nullptr);
  const size_t near = first_directional();
  share_ = 1.0 / (count_ - near + (near > 0));
  cumulative_.clear();
  if (near >= kManyLights) {
    std::vector<LightBounds> bounds;
    for (const PointLight& p : points) {
      LightBounds& light = bounds.emplace_back();
      light.box.extend(p.position);
      light.intensity = max_component(p.intensity);
    }
    for (const SpotLight& s : spots) {
      LightBounds& light = bounds.emplace_back();
      light.box.extend(s.position);
      light.axis = s.direction;
      light.normals = 0.0;
      light.cos_emission = s.cos_outer;
      light.intensity = max_component(s.intensity);
    }
    for (const AreaLight& a : areas) bounds.push_back(a.bounds());
    tree_.build(std::move(bounds));
    return;
  }
  for (const PointLight& p : points) cumulative_.push_back(4.0 * kPi * max_component(p.intensity));
  for (const SpotLight& s : spots) cumulative_.push_back(power(s));
  for (const AreaLight& a : areas) cumulative_.push_back(kPi * a.area() * max_component(a.radiance));
  double total = 0.0, sum = 0.0;
  for (double light : cumulative_) total += light;
  for (double& light : cumulative_) light = sum += light + kLeastShare * total;
}

LightChoice Lights::choose(double u, const LitPlace& place) const {
  const size_t near = first_directional();
  if (near == 0 || u >= share_) {
    const size_t distant = static_cast<size_t>((near == 0 ? u : u - share_) / share_);
    return {std::min(near + distant, count() - 1), share_};
  }
  u /= share_;
  LightChoice out;
  if (built_with("light_tree") && !tree_.empty()) {
    out.light = tree_.choose(u, place, out.probability);
    out.probability *= share_;
    return out;
  }
  auto found = std::upper_bound(cumulative_.begin(), cumulative_.end(), u * cumulative_.back());
  out.light = std::min<size_t>(found - cumulative_.begin(), near - 1);
  out.probability = probability(out.light, place);
  return out;
}

double Lights::probability(size_t light, const LitPlace& place) const {
  if (light >= first_directional()) return share_;
  if (built_with("light_tree") && !tree_.empty()) return share_ * tree_.probability(light, place);
  return share_ * ((cumulative_[light] - (light == 0 ? 0.0 : cumulative_[light - 1])) / cumulative_.back());
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
  out.error = 32 * kUnitRoundoff * (max_abs(piece.origin) + max_abs(piece.edge1) + max_abs(piece.edge2)) + light.sideways;
  return out;
}

}  // namespace tilecast
