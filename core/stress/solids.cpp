// Gates 12 to 17: the solids, against their implicit functions in quadruple precision.
#include <cstring>

#include "stress/quad.h"
#include "stress/shapes.h"
#include "stress/stress.h"

namespace tilecast::stress {
namespace {

constexpr double kUlp = 2.0 * kUnitRoundoff;

double ulp_of(double x) { return std::ldexp(kUlp, std::ilogb(x)); }

struct Crossings {
  SolidCrossing item[kMaxSolidCrossings];
  int count;

  Crossings(const Solid& solid, const Ray& line) : count(crossings(solid, line, item)) {}
  bool in_order() const {
    bool good = count % 2 == 0;
    for (int i = 0; i < count; ++i) {
      bool later = i == 0 || item[i - 1].t < item[i].t;
      good = good && std::isfinite(item[i].t) && item[i].entering == (i % 2 == 0) && later;
    }
    return good;
  }
};

// Runs one(random, case number) for each case and adds up, or takes the largest. A case's random numbers are its own.
template <class F>
std::function<double(uint64_t, uint64_t)> each(Combine combine, uint64_t family, F one) {
  return [=](uint64_t first, uint64_t count) {
    double figure = 0.0;
    for (uint64_t i = first; i < first + count; ++i) {
      Random random(family << 48 | i);
      double value = one(random, i);
      if (combine == Combine::Sum)
        figure += value;
      else if (!(value <= figure))
        figure = value;
    }
    return figure;
  };
}

// --- Gate 13

// The line's distance from the centre is anything from 0 to the radius, and often within 1e-12 of it.
double far_sphere(Random& random, uint64_t) {
  Sphere sphere{power_of_ten(random, -6, 6)};
  Vec3 direction = random_direction(random), aside = glm::normalize(glm::cross(direction, random_direction(random)));
  double miss = random() & 1 ? uniform(random, 0, 1) : 1.0 - power_of_ten(random, -12, 0);
  Vec3 origin = sphere.radius * (miss * aside - power_of_ten(random, 0, 8) * direction);
  Ray line{origin, direction * power_of_ten(random, -3, 3)};
  const Vec3 &o = line.origin, &d = line.direction;
  Quad a = square(d.x) + square(d.y) + square(d.z), b = Quad(o.x) * d.x + Quad(o.y) * d.y + Quad(o.z) * d.z;
  QuadPoint nearest = at(line, -b / a);
  Quad left = square(sphere.radius) - square(nearest.x) - square(nearest.y) - square(nearest.z);
  if (magnitude(left) < 1e-13 * square(sphere.radius)) return 0.0;  // it may touch or not
  Crossings found(sphere, line);
  if (found.count != (left > 0 ? 2 : 0) || !found.in_order()) return kInfinity;
  double worst = 0.0;
  for (int i = 0; i < found.count; ++i) {
    Quad root = root_of(left / a), t = i == 0 ? -b / a - root : -b / a + root;
    Quad off = magnitude(found.item[i].t - t) / ulp_of(static_cast<double>(t));
    worst = std::max(worst, static_cast<double>(off));
  }
  return worst;
}

// --- Gate 14

double quadratic(Random& random, uint64_t) {
  auto sign = [&] { return random() & 1 ? 1.0 : -1.0; };
  double b = sign() * power_of_ten(random, -3, 3), a = sign() * std::fabs(b) * power_of_ten(random, -300, 0);
  double c = sign() * power_of_ten(random, -6, 6);
  if (random() & 1) {  // nearly a double root
    double near = b * (b / a) * (1.0 - power_of_ten(random, -16, 0));
    if (std::isfinite(near)) c = near;
  }
  if (random() % 16 == 0) a = 0.0 * sign();
  QuadraticRoots roots;
  if (!solve(a, b, c, roots)) {
    Quad discriminant = square(b) - Quad(a) * c;
    return discriminant > 1e-30 * square(b) ? kInfinity : 0.0;
  }
  double worst = 0.0;
  int finite = 0;
  for (double t : {roots.low, roots.high}) {
    if (!std::isfinite(t)) continue;
    ++finite;
    Quad residual = magnitude(Quad(a) * t * t + 2 * Quad(b) * t + c);
    Quad scale = magnitude(a) * square(t) + 2 * magnitude(Quad(b) * t) + magnitude(c);
    worst = std::max(worst, static_cast<double>(residual / (scale * kUlp)));
  }
  return finite > 0 && roots.low <= roots.high ? worst : kInfinity;
}

// --- Gate 15

double rim(Random& random, uint64_t i) {
  Solid solid = random_solid(static_cast<int>(i % kSolidKinds), random);
  Ray line = line_at(awkward_point(solid, random), size_of(solid), random);
  return !Crossings(solid, line).in_order();
}

// --- Gates 16 and 17

Torus random_torus(Random& random) {
  double radius = power_of_ten(random, -6, 6);
  return {radius, random() % 16 ? radius * power_of_ten(random, -6, 0) : radius};
}

// A line near a point of the surface or of the tube's middle; half of them nearly touch there.
Ray line_at_torus(const Torus& torus, double most_radii, Random& random) {
  double u = 2 * kPi * uniform(random, 0, 1), v = 2 * kPi * uniform(random, 0, 1);
  Vec3 out(std::cos(u), 0.0, std::sin(u)), normal = out * std::cos(v) + Vec3(0.0, std::sin(v), 0.0);
  Vec3 direction = random_direction(random);
  double depth = 1.0;
  if (random() & 1) {
    direction = glm::normalize(glm::cross(normal, direction));
    depth = 1.0 + (random() & 1 ? 1.0 : -1.0) * power_of_ten(random, -14, 0);
  } else {
    depth = uniform(random, 0, 1);
  }
  if (random() % 4 == 0)  // along the tube
    direction = glm::normalize(Vec3(-out.z, 0.1 * uniform(random, -1, 1), out.x));
  Vec3 target = torus.radius * out + depth * torus.minor_radius * normal;
  Vec3 origin = target - torus.radius * power_of_ten(random, -1, most_radii) * direction;
  return {origin, direction * power_of_ten(random, -2, 2)};
}

// The exact count, unless it changes when the tube's radius does by 4 ulp of the line's and the torus's coordinates.
double torus_count(Random& random, uint64_t) {
  Torus torus = random_torus(random);
  Ray line = line_at_torus(torus, 2, random);
  Crossings found(torus, line);
  int exact = sturm_count(quartic_along(torus, line));
  if (found.count == exact) return !found.in_order();
  double moved = 4 * ulp_of(std::max(max_abs(line.origin), torus.radius));
  Torus thinner = torus, thicker = torus;
  thinner.minor_radius -= moved;
  thicker.minor_radius += moved;
  return thinner.minor_radius > 0.0 && sturm_count(quartic_along(thinner, line)) == exact &&
         sturm_count(quartic_along(thicker, line)) == exact;
}

double torus_residual(Random& random, uint64_t) {
  Torus torus = random_torus(random);
  Ray line = line_at_torus(torus, 2, random);
  QuadPolynomial p = quartic_along(torus, line);
  Crossings found(torus, line);
  double worst = 0.0;
  for (int i = 0; i < found.count; ++i) {
    double t = found.item[i].t;
    long double scale = 0;  // no term of it cancels
    for (int k = p.degree; k >= 0; --k) scale = scale * std::fabs(t) + std::fabs(static_cast<long double>(p.coefficient[k]));
    worst = std::max(worst, static_cast<double>(std::fabs(static_cast<long double>(evaluate(p, t))) / (scale * kUnitRoundoff)));
  }
  return worst;
}

// Of radius ratio 1e6: where the function changes its sign, in units of the error bound that goes with the crossing.
double thin_torus(Random& random, uint64_t) {
  double radius = power_of_ten(random, -6, 6);
  Torus torus{radius, 1e-6 * radius};
  Ray line = line_at_torus(torus, 1, random);
  Crossings found(torus, line);
  for (int i = 0; i < found.count; ++i) {
    const SolidCrossing& c = found.item[i];
    bool before = implicit(torus, at(line, Quad(c.t) - c.error)) > 0;
    bool after = implicit(torus, at(line, Quad(c.t) + c.error)) > 0;
    // Two crossings within their bounds of each other may be none, and the line inside or outside at both.
    auto apart = [&](int other) {
      if (other < 0 || other >= found.count) return true;
      return std::fabs(c.t - found.item[other].t) > c.error + found.item[other].error;
    };
    if (apart(i - 1) && apart(i + 1) && (before != c.entering || after == c.entering)) return 1.0;
  }
  return !found.in_order();
}

// --- Gate 12

Solid scaled(const Solid& solid, double k) {
  Solid out = solid;
  if (auto* s = std::get_if<Sphere>(&out)) s->radius *= k;
  if (auto* b = std::get_if<Block>(&out)) b->lo *= k, b->hi *= k;
  if (auto* c = std::get_if<Cylinder>(&out)) c->radius *= k, c->height *= k;
  if (auto* c = std::get_if<Cone>(&out)) c->radius *= k, c->top_radius *= k, c->height *= k;
  if (auto* c = std::get_if<Capsule>(&out)) c->radius *= k, c->height *= k;
  if (auto* t = std::get_if<Torus>(&out)) t->radius *= k, t->minor_radius *= k;
  if (auto* b = std::get_if<RoundedBlock>(&out)) b->lo *= k, b->hi *= k, b->radius *= k;
  if (auto* h = std::get_if<Halfspace>(&out)) h->offset *= k, h->lo *= k, h->hi *= k;
  if (auto* q = std::get_if<Quadric>(&out)) {
    std::array<double, 10> c = q->coefficients;
    for (int i = 0; i < 9; ++i) c[i] /= (i < 6 ? k * q->unit : 1.0) * (k * q->unit);
    *q = Quadric::of(c, q->lo * k, q->hi * k);
  }
  return out;
}

double scaling(Random& random, uint64_t i) {
  Solid solid = random_solid(static_cast<int>(i % kSolidKinds), random);
  Ray line = line_at(awkward_point(solid, random), size_of(solid), random);
  int k = static_cast<int>(random() % 81) - 40, stretch = static_cast<int>(random() % 81) - 40;
  Ray larger{line.origin * std::ldexp(1.0, k), line.direction * std::ldexp(1.0, stretch)};
  Crossings before(solid, line), after(scaled(solid, std::ldexp(1.0, k)), larger);
  bool same = before.count == after.count;
  for (int j = 0; same && j < before.count; ++j) {
    const SolidCrossing &a = before.item[j], &b = after.item[j];
    same = std::ldexp(a.t, k - stretch) == b.t && std::ldexp(a.error, k - stretch) == b.error && a.face == b.face;
  }
  return !same;
}

}  // namespace

void add_solids(std::vector<Case>& out) {
  constexpr uint64_t million = 1'000'000, long_run = 100'000'000, cheap = 1'000'000'000;
  auto add = [&](const char* name, int gate, const char* figure, double limit, Combine combine, uint64_t most, auto one) {
    out.push_back({name, gate, figure, limit, combine, million, most, each(combine, out.size() + 1, one)});
  };
  add("solids-scaled", 12, "solids that change with a power of two", 0, Combine::Sum, cheap, scaling);
  add("sphere-from-afar", 13, "error of t, ulp", 4, Combine::Max, cheap, far_sphere);
  add("quadratic", 14, "backward error, ulp", 8, Combine::Max, cheap, quadratic);
  add("rims-and-apexes", 15, "lines that cross unevenly or out of order", 0, Combine::Sum, long_run, rim);
  add("torus-roots", 16, "lines with another number of crossings than Sturm's", 0, Combine::Sum, cheap, torus_count);
  add("torus-residual", 17, "scaled residual, u", 16, Combine::Max, cheap, torus_residual);
  add("thin-torus", 0, "crossings off by more than their error bound", 0, Combine::Sum, long_run, thin_torus);
}

}  // namespace tilecast::stress
