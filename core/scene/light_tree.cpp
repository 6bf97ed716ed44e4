#include "scene/light_tree.h"

#include <algorithm>

#include "base/elementary.h"

namespace tilecast {
namespace {

constexpr int kLightBins = 12;
constexpr size_t kFewLights = 4;     // lights that are just halved
constexpr int kGreedyDepth = 32;     // further down nodes are halved, so that the tree ends
constexpr double kNearLights = 3.0;  // radii

// Cosine and sine of max(0, a - b), of angles in [0, pi].
double cos_less(double sin_a, double cos_a, double sin_b, double cos_b) {
  return cos_a > cos_b ? 1.0 : cos_a * cos_b + sin_a * sin_b;
}
double sin_less(double sin_a, double cos_a, double sin_b, double cos_b) {
  return cos_a > cos_b ? 0.0 : sin_a * cos_b - cos_a * sin_b;
}
double other(double x) { return std::sqrt(std::max(0.0, 1.0 - x * x)); }

// A cone around two, with room for rounding.
void extend_cone(LightBounds& a, const LightBounds& b) {
  const double apart = turns_between(a.axis, b.axis);
  if (std::min(apart + b.normals, 0.5) <= a.normals) return;
  if (std::min(apart + a.normals, 0.5) <= b.normals) {
    a.axis = b.axis, a.normals = b.normals;
    return;
  }
  const double both = 0.5 * (a.normals + apart + b.normals) + 1e-12;
  const double turn = both - a.normals;  // of a's axis towards b's
  double sine_apart, sine_turn, sine_rest, cosine;
  sincos_2pi(apart, sine_apart, cosine);
  sincos_2pi(turn, sine_turn, cosine);
  sincos_2pi(std::max(0.0, apart - turn), sine_rest, cosine);
  const Vec3 axis = sine_rest * a.axis + sine_turn * b.axis;
  const double length = glm::length(axis);
  if (both >= 0.5 || !(length > 1e-9 * sine_apart) || !(sine_apart > 1e-9)) {
    a.normals = apart < 0.25 ? std::min(0.5, both + apart) : 0.5;  // about a's axis still
    return;
  }
  a.axis = axis / length;
  a.normals = both;
}

LightBounds around(const LightBounds& a, const LightBounds& b) {
  if (a.box.empty()) return b;
  if (b.box.empty()) return a;
  LightBounds out = a;
  out.box.extend(b.box);
  out.cos_emission = std::min(a.cos_emission, b.cos_emission);
  out.intensity = a.intensity + b.intensity;
  extend_cone(out, b);
  return out;
}

// The measure of the directions into which light goes: equation 1 of the paper.
double orientation(const LightBounds& b) {
  const double o = 2.0 * kPi * b.normals;
  const double emission = atan2_turns(other(b.cos_emission), b.cos_emission);
  const double widest = 2.0 * kPi * std::min(0.5, b.normals + emission);
  double sine, cosine;
  sincos_2pi(b.normals, sine, cosine);
  const double turns = b.normals - widest / kPi;  // o - 2 widest
  return 2.0 * kPi * (1.0 - cosine) +
         0.5 * kPi * (2.0 * widest * sine - cos_2pi(turns - std::floor(turns)) - 2.0 * o * sine + cosine);
}

// What a node costs, by the surface area orientation heuristic.
double cost(const LightBounds& b) {
  if (b.box.empty()) return 0.0;
  const Vec3 d = b.box.hi - b.box.lo;
  return b.intensity * orientation(b) * glm::dot(d, d);  // the surface of a ball, as nodes are
}

}  // namespace

double LightTree::Node::importance(const LitPlace& place) const {
  const Vec3 from = place.point - centre;  // from the lights
  const double distance2 = glm::dot(from, from), radius2 = radius * radius;
  double out = intensity / std::max({distance2, radius2, 1e-200});
  if (distance2 <= radius2) return out;  // in the midst of them anything is possible
  const Vec3 way = from / std::sqrt(distance2);
  const double sin_ball = std::min(1.0, radius / std::sqrt(distance2)), cos_ball = other(sin_ball);
  const double cos_axis = glm::dot(axis, way), sin_axis = other(cos_axis);
  const double cos_rest = cos_less(sin_axis, cos_axis, sin_normals, cos_normals);
  const double sin_rest = sin_less(sin_axis, cos_axis, sin_normals, cos_normals);
  const double cos_least = cos_less(sin_rest, cos_rest, sin_ball, cos_ball);
  if (cos_least <= cos_emission) return 0.0;
  if (cos_emission >= 0.0) out *= cos_least;  // as a surface shines; a wide spot does not
  if (place.normal != Vec3(0.0)) {
    const double cosine = -glm::dot(place.normal, way);
    out *= std::max(0.0, cos_less(other(cosine), cosine, sin_ball, cos_ball));
  }
  return out;
}

void LightTree::build(std::vector<LightBounds> lights) {
  nodes_.clear();
  leaves_.resize(lights.size());
  if (lights.empty()) return;
  std::vector<Item> items(lights.size());
  for (uint32_t i = 0; i < lights.size(); ++i) items[i] = {lights[i], i};
  nodes_.reserve(2 * lights.size() - 1);
  build(items, 0, items.size(), 0);
}

void LightTree::build(std::vector<Item>& items, size_t begin, size_t end, int depth) {
  const size_t number = nodes_.size();
  nodes_.emplace_back();
  LightBounds all;
  Box centres;
  for (size_t i = begin; i < end; ++i) {
    all = around(all, items[i].bounds);
    centres.extend(items[i].bounds.box.centre());
  }
  Node node;
  node.centre = all.box.centre();
  node.radius = glm::length(glm::max(all.box.hi - node.centre, node.centre - all.box.lo)) * (1.0 + 8 * kUnitRoundoff);
  node.axis = all.axis;
  sincos_2pi(all.normals, node.sin_normals, node.cos_normals);
  node.cos_emission = all.cos_emission;
  node.intensity = all.intensity;
  node.second = 0;
  node.light = items[begin].light;
  if (end - begin == 1) {
    leaves_[node.light] = static_cast<uint32_t>(number);
    node.end = static_cast<uint32_t>(number + 1);
    nodes_[number] = node;
    return;
  }
  const Vec3 extent = centres.hi - centres.lo;
  int axis = extent.x >= extent.y ? (extent.x >= extent.z ? 0 : 2) : (extent.y >= extent.z ? 1 : 2);
  size_t middle = begin;
  if (end - begin > kFewLights && depth < kGreedyDepth && extent[axis] > 0.0) {
    auto bin_of = [&](const Item& item, int a) {
      const double at = (item.bounds.box.centre()[a] - centres.lo[a]) / extent[a];
      return std::min(kLightBins - 1, static_cast<int>(at * kLightBins));
    };
    double best = kInfinity;
    int best_axis = axis, best_bin = 0;
    for (int a = 0; a < 3; ++a) {
      if (!(extent[a] > 0.0)) continue;
      LightBounds bins[kLightBins], from_right[kLightBins];
      for (size_t i = begin; i < end; ++i) {
        LightBounds& bin = bins[bin_of(items[i], a)];
        bin = around(bin, items[i].bounds);
      }
      from_right[kLightBins - 1] = bins[kLightBins - 1];
      for (int b = kLightBins - 2; b > 0; --b) from_right[b] = around(bins[b], from_right[b + 1]);
      LightBounds left;
      for (int b = 0; b + 1 < kLightBins; ++b) {
        left = around(left, bins[b]);
        if (left.box.empty() || from_right[b + 1].box.empty()) continue;
        const double here = extent[axis] / extent[a] * (cost(left) + cost(from_right[b + 1]));
        if (here < best) best = here, best_axis = a, best_bin = b;
      }
    }
    auto split = std::stable_partition(items.begin() + begin, items.begin() + end,
                                       [&](const Item& item) { return bin_of(item, best_axis) <= best_bin; });
    middle = split - items.begin();
  }
  if (middle == begin || middle == end) {
    middle = begin + (end - begin) / 2;
    auto before = [&](const Item& a, const Item& b) {
      const double x = a.bounds.box.centre()[axis], y = b.bounds.box.centre()[axis];
      return x != y ? x < y : a.light < b.light;
    };
    std::nth_element(items.begin() + begin, items.begin() + middle, items.begin() + end, before);
  }
  build(items, begin, middle, depth + 1);
  node.second = static_cast<uint32_t>(nodes_.size());
  build(items, middle, end, depth + 1);
  node.end = static_cast<uint32_t>(nodes_.size());
  nodes_[number] = node;
}

bool LightTree::Node::near(const LitPlace& place) const {
  const Vec3 from = place.point - centre;
  return second > 0 && glm::dot(from, from) < kNearLights * kNearLights * radius * radius;
}

double LightTree::Cut::total() const {
  double sum = 0.0;
  for (int i = 0; i < size; ++i) sum += importance[i];
  return sum;
}

// Splits what is near, the most important first.
LightTree::Cut LightTree::cut(const LitPlace& place) const {
  Cut out;
  bool near[kCut];
  auto put = [&](int at, uint32_t node) {
    out.nodes[at] = node;
    out.importance[at] = nodes_[node].importance(place);
    near[at] = out.importance[at] > 0.0 && nodes_[node].near(place);
  };
  put(0, 0);
  for (out.size = 1; out.size < kCut; ++out.size) {
    int best = -1;
    for (int i = 0; i < out.size; ++i)
      if (near[i] && (best < 0 || out.importance[i] > out.importance[best])) best = i;
    if (best < 0) break;
    const uint32_t node = out.nodes[best];
    put(best, node + 1);
    put(out.size, nodes_[node].second);
  }
  return out;
}

// Of the choice between a node's halves, the probability of the first; not a number where neither reaches the place.
double LightTree::share_of_first(uint32_t node, const LitPlace& place) const {
  const double first = nodes_[node + 1].importance(place);
  return first / (first + nodes_[nodes_[node].second].importance(place));
}

size_t LightTree::choose(double u, const LitPlace& place, double& probability) const {
  const Cut from = cut(place);
  const double total = from.total();
  probability = 0.0;
  if (!(total > 0.0)) return 0;
  int chosen = -1;
  u *= total;
  for (int i = 0; i < from.size; ++i) {
    if (!(from.importance[i] > 0.0)) continue;
    if (chosen >= 0) u -= from.importance[chosen];
    chosen = i;
    if (u < from.importance[i]) break;
  }
  u = std::min(u / from.importance[chosen], 1.0 - kUnitRoundoff);
  probability = from.importance[chosen] / total;
  uint32_t at = from.nodes[chosen];
  while (nodes_[at].second > 0) {
    const double share = share_of_first(at, place);
    if (!(share >= 0.0)) {
      probability = 0.0;
      return 0;
    }
    if (u < share) {
      u /= share;
      probability *= share;
      at = at + 1;
    } else {
      u = std::min((u - share) / (1.0 - share), 1.0 - kUnitRoundoff);
      probability *= 1.0 - share;
      at = nodes_[at].second;
    }
  }
  return nodes_[at].light;
}

double LightTree::probability(size_t light, const LitPlace& place) const {
  const uint32_t leaf = leaves_[light];
  const Cut from = cut(place);
  int i = 0;
  while (leaf < from.nodes[i] || leaf >= nodes_[from.nodes[i]].end) ++i;
  if (!(from.importance[i] > 0.0)) return 0.0;
  double out = from.importance[i] / from.total();
  for (uint32_t at = from.nodes[i]; nodes_[at].second > 0;) {
    const uint32_t next = nodes_[at].second;
    const double share = share_of_first(at, place);
    if (!(share >= 0.0)) return 0.0;
    out *= leaf < next ? share : 1.0 - share;
    at = leaf < next ? at + 1 : next;
  }
  return out;
}

}  // namespace tilecast
