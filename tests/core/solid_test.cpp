// Every kind of solid against its implicit function in quadruple precision.
#include <gtest/gtest.h>

#include "geometry/sure_crossing.h"
#include "scene/surface.h"
#include "stress/quad.h"
#include "stress/scenes.h"
#include "stress/shapes.h"

namespace tilecast {
namespace {

using namespace stress;

class EverySolid : public ::testing::TestWithParam<int> {
 protected:
  Random random{static_cast<uint64_t>(GetParam())};
  Solid solid() { return random_solid(GetParam(), random); }
  Vec3 somewhere(const Solid& solid) {
    Box box = bounds(solid);
    Vec3 p;
    for (int i = 0; i < 3; ++i) p[i] = uniform(random, box.lo[i], box.hi[i]);
    return p;
  }
  // Half of the lines in flat faces are in.
  static bool in_a_face(const Solid& solid, const Ray& line) {
    Box box = bounds(solid);
    for (int i = 0; i < 3; ++i)
      if (line.direction[i] == 0.0 && (line.origin[i] == box.lo[i] || line.origin[i] == box.hi[i])) return true;
    return false;
  }
  // At a point of the bounds, or where tracers crack.
  Ray line(const Solid& solid) {
    return line_at(random() & 1 ? somewhere(solid) : awkward_point(solid, random), size_of(solid), random);
  }
  // test(solid, line, crossing), until one fails.
  template <class Test>
  void for_crossings(int lines, Test&& test) {
    for (int i = 0; i < lines && !HasFatalFailure(); ++i) {
      SCOPED_TRACE("case " + std::to_string(i));
      Solid s = solid();
      Ray ray = line_at(somewhere(s), size_of(s), random);
      SolidCrossing list[kMaxSolidCrossings];
      int count = crossings(s, ray, list);
      for (int k = 0; k < count && !HasFatalFailure(); ++k) test(s, ray, list[k]);
    }
  }
};

TEST_P(EverySolid, IsCrossedWhereItsFunctionChangesSign) {
  int crossed = 0, inside_count = 0;
  for (int i = 0; i < 20000; ++i) {
    Solid s = solid();
    Ray ray = line(s);
    SolidCrossing list[kMaxSolidCrossings];
    int count = crossings(s, ray, list);
    crossed += count;
    ASSERT_EQ(count % 2, 0);
    for (int k = 0; k < count; ++k) {
      ASSERT_EQ(list[k].entering, k % 2 == 0);
      ASSERT_TRUE(std::isfinite(list[k].t) && list[k].error >= 0.0);
      ASSERT_TRUE(0 <= list[k].face && list[k].face < face_count(s));
      if (k > 0) { ASSERT_LT(list[k - 1].t, list[k].t); }
    }
    if (in_a_face(s, ray)) continue;
    // Points of the line, but for those within the error bounds of a crossing; more of them just outside of these.
    double length = std::sqrt(glm::dot(ray.direction, ray.direction));
    double middle = -glm::dot(ray.origin, ray.direction) / (length * length);
    double reach = 1.5 * (max_abs(bounds(s).lo) + max_abs(bounds(s).hi)) / length;
    std::vector<double> points;
    for (int k = 0; k < 12; ++k) points.push_back(middle + uniform(random, -reach, reach));
    for (int k = 0; k < count; ++k)
      for (double side : {-1.01, 1.01, -1e3, 1e3})
        points.push_back(list[k].t + side * (list[k].error + kUnitRoundoff * std::fabs(list[k].t)));
    for (double t : points) {
      bool sure = true, inside = false;
      for (int k = 0; k < count; ++k) {
        sure = sure && std::fabs(t - list[k].t) > list[k].error;
        if (list[k].t < t) inside = list[k].entering;
      }
      if (!sure) continue;
      inside_count += inside;
      ASSERT_EQ(implicit(s, at(ray, t)) < 0, inside) << "case " << i << ", t " << t << " of " << count << " crossings";
    }
  }
  EXPECT_GT(crossed, 10000);
  EXPECT_GT(inside_count, 10000);
}

TEST_P(EverySolid, HasTheSameCrossingsWhereTheyAreSure) {
  int told = 0;
  for (int i = 0; i < 5000; ++i) {
    const Solid s = solid();
    Ray ray = line_at(somewhere(s), size_of(s), random);
    SolidCrossing list[kMaxSolidCrossings], one;
    auto well_apart = [&] {
      if (crossings(s, ray, list) != 2) return false;
      return list[1].t - list[0].t > 1e-6 * (std::fabs(list[0].t) + std::fabs(list[1].t));
    };
    if (!well_apart()) continue;
    const int number = i % 2;
    if (i % 8 < 6) ray.origin = ray.at(list[number].t);  // to where rounding decides what is ahead
    if (i % 8 < 4) ray.origin += uniform(random, -16, 16) * kUnitRoundoff * size_of(s) * random_direction(random);
    if (!well_apart()) continue;
    ASSERT_TRUE(sure_crossing(s, ray, number, one));
    ASSERT_EQ(one.t, list[number].t);
    ASSERT_EQ(one.face, list[number].face);
    ASSERT_EQ(one.entering, list[number].entering);
    const std::optional<bool> ahead = sure_crossing_ahead(s, ray, number);
    told += ahead.has_value();
    ASSERT_EQ(ahead.value_or(one.t > 0.0), one.t > 0.0);
  }
  if (GetParam() < 3) { EXPECT_GT(told, 1000); }
}

TEST_P(EverySolid, MovesACrossingByNoMoreThanItsErrorWhenTheLineIsRounded) {
  for (int i = 0; i < 20000; ++i) {
    Solid s = solid();
    Ray ray = line_at(somewhere(s), size_of(s), random), moved = ray;
    for (int k = 0; k < 3; ++k) {
      moved.origin[k] = std::nextafter(ray.origin[k], random() & 1 ? kInfinity : -kInfinity);
      moved.direction[k] *= 1.0 + (random() & 1 ? 2.0 : -2.0) * kUnitRoundoff;
    }
    SolidCrossing list[kMaxSolidCrossings], other[kMaxSolidCrossings];
    int count = crossings(s, ray, list);
    if (crossings(s, moved, other) != count) continue;
    for (int k = 0; k < count; ++k) {
      ASSERT_LE(std::fabs(list[k].t - other[k].t), list[k].error + other[k].error) << "case " << i;
    }
  }
}

TEST_P(EverySolid, BringsAPointOntoItsSurfaceAndKnowsTheWayOut) {
  for_crossings(5000, [](const Solid& s, const Ray& ray, const SolidCrossing& crossing) {
    Vec3 p = project(s, crossing.face, ray.at(crossing.t)), n = outward(s, crossing.face, p);
    // What Surface takes for the point's error, along the normal.
    n *= projection_error(s, p) / std::sqrt(glm::dot(n, n));
    auto beyond = [&](double side) {
      return implicit(s, {Quad(p.x) + side * n.x, Quad(p.y) + side * n.y, Quad(p.z) + side * n.z});
    };
    ASSERT_GT(beyond(1.0), 0) << "face " << crossing.face;
    // No farther than the line's own rounding, and the crossing's error along it.
    Vec3 moved = p - ray.at(crossing.t);
    double reach = 64 * kUnitRoundoff * (max_abs(ray.origin) + size_of(s)) + crossing.error * max_abs(ray.direction);
    ASSERT_LE(max_abs(moved), reach) << "face " << crossing.face;
  });
}

TEST_P(EverySolid, StaysWithinItsBounds) {
  for_crossings(5000, [](const Solid& s, const Ray& ray, const SolidCrossing& crossing) {
    Box box = bounds(s);
    Vec3 p = ray.at(crossing.t);
    Vec3 slack = 8 * kUnitRoundoff * (glm::abs(ray.origin) + max_abs(box.lo) + max_abs(box.hi)) +
                 crossing.error * glm::abs(ray.direction);
    for (int axis = 0; axis < 3; ++axis) {
      ASSERT_GE(p[axis], box.lo[axis] - slack[axis]);
      ASSERT_LE(p[axis], box.hi[axis] + slack[axis]);
    }
  });
}

const char* const kNames[] = {"Sphere", "Block",        "Cylinder", "Cone",     "Capsule",
                              "Torus",  "RoundedBlock", "Quadric",  "Halfspace"};
static_assert(std::size(kNames) == kSolidKinds);
INSTANTIATE_TEST_SUITE_P(Kinds, EverySolid, ::testing::Range(0, kSolidKinds),
                         [](const auto& info) { return std::string(kNames[info.param]); });

// Closed forms.

std::vector<double> crossings_of(const Solid& solid, const Ray& line) {
  SolidCrossing list[kMaxSolidCrossings];
  std::vector<double> out;
  for (int i = 0, count = crossings(solid, line, list); i < count; ++i) out.push_back(list[i].t);
  return out;
}

TEST(Solid, IsCrossedWhereSchoolGeometrySaysSo) {
  using List = std::vector<double>;
  Vec3 x(1, 0, 0), y(0, 1, 0);
  EXPECT_EQ(crossings_of(Torus{2.0, 0.5}, {Vec3(-5, 0, 0), x}), (List{2.5, 3.5, 6.5, 7.5}));
  EXPECT_EQ(crossings_of(Torus{2.0, 0.5}, {Vec3(2, -5, 0), y}), (List{4.5, 5.5}));
  EXPECT_EQ(crossings_of(Torus{2.0, 0.5}, {Vec3(0, -5, 0), y}), List{});
  EXPECT_EQ(crossings_of(Cone{1.0, 0.0, 2.0}, {Vec3(-3, 0, 0), x}), (List{2.5, 3.5}));
  EXPECT_EQ(crossings_of(Cone{1.0, 0.0, 2.0}, {Vec3(0, -3, 0), y}), (List{2, 4}));          // along the axis, to the apex
  EXPECT_EQ(crossings_of(Cone{1.0, 0.0, 2.0}, {Vec3(2, -3, 0), Vec3(-1, 2, 0)}), List{});  // along the side
  EXPECT_EQ(crossings_of(Cone{1.0, 0.0, 2.0}, {Vec3(0, -1, 0), Vec3(-1, 2, 0)}), (List{0, 0.5}));
  EXPECT_EQ(crossings_of(Cone{2.0, 1.0, 2.0}, {Vec3(-3, 0, 0), x}), (List{1.5, 4.5}));
  EXPECT_EQ(crossings_of(Capsule{1.0, 2.0}, {Vec3(0, -5, 0), y}), (List{3, 7}));
  EXPECT_EQ(crossings_of(Capsule{1.0, 2.0}, {Vec3(-3, 0.5, 0), x}), (List{2, 4}));
  EXPECT_EQ(crossings_of(RoundedBlock{Vec3(-1), Vec3(1), 0.25}, {Vec3(-3, 0.5, 0), x}), (List{2, 4}));
  EXPECT_EQ(crossings_of(RoundedBlock{Vec3(-1), Vec3(1), 1.0}, {Vec3(-3, 0, 0), x}), (List{2, 4}));
  EXPECT_EQ(crossings_of(RoundedBlock{Vec3(-1), Vec3(1), 0.5}, {Vec3(-3, 0.96875, 0.96875), x}), (List{}));  // past the corner
  Quadric two_sheets = Quadric::of({1, -1, 1, 0, 0, 0, 0, 0, 0, 1}, Vec3(-3), Vec3(3));
  EXPECT_EQ(crossings_of(two_sheets, {Vec3(0, -5, 0), y}), (List{2, 4, 6, 8}));
  Quadric paraboloid = Quadric::of({1, 0, 1, 0, 0, 0, 0, -1, 0, 0}, Vec3(-1, 0, -1), Vec3(1, 1, 1));
  EXPECT_EQ(crossings_of(paraboloid, {Vec3(0.5, -1, 0), y}), (List{1.25, 2}));
}

TEST(Solid, HoldsItsDigitsAtTheEndsOfTheRange) {
  for (double size : {1e-100, 1e-30, 1e30, 1e100})
    for (int kind = 0; kind < kSolidKinds - 1; ++kind) {
      Solid solids[] = {Sphere{size},        Block{Vec3(-size), Vec3(size)}, Cylinder{size, size}, Cone{size, 0.0, size},
                        Capsule{size, size}, Torus{size, 0.5 * size},        RoundedBlock{Vec3(-size), Vec3(size), 0.25 * size},
                        Quadric::of({1, 1, 1, 0, 0, 0, 0, 0, 0, 0}, Vec3(-size), Vec3(size))};
      auto list = crossings_of(solids[kind], {Vec3(-3 * size, 0.1 * size, 0.2 * size), Vec3(size, 0, 0)});
      if (kind == 7) {
        EXPECT_TRUE(list.empty());  // a single point
      } else {
        ASSERT_GE(list.size(), 2u) << kind << " " << size;
        EXPECT_LT(std::fabs(list[0] - 3.0), 1.6);
      }
    }
}

TEST(Solid, RefusesWhatIsNone) {
  auto message = [](auto make) {
    try {
      SceneBuilder().add_solid(make());
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const double nan = std::nan("");
  EXPECT_EQ(message([] { return Sphere{-0.5}; }), "radius: must be positive, got -0.5");
  EXPECT_EQ(message([&] { return Capsule{nan, 1}; }), "radius: must be positive, got nan");
  EXPECT_EQ(message([] { return Cylinder{1, 1e101}; }), "height: must lie between 1e-100 and 1e100, got 1e+101");
  EXPECT_EQ(message([] { return Cone{0, 0, 1}; }), "radius: must be positive where top_radius is 0, got 0");
  EXPECT_EQ(message([] { return Cone{1, -1, 1}; }), "top_radius: must not be negative, got -1");
  EXPECT_EQ(message([] { return Torus{1, 2}; }), "minor_radius: must be at most radius = 1, got 2");
  EXPECT_EQ(message([] { return RoundedBlock{Vec3(-1), Vec3(1, 2, 3), 1.5}; }),
            "radius: must be at most half the shortest side, 1, got 1.5");
  EXPECT_EQ(message([] { return Block{Vec3(-1), Vec3(1, -1, 1)}; }), "max[1]: must be greater than min, got -1 and -1");
  EXPECT_EQ(message([] { return Quadric::of({0, 0, 0, 0, 0, 0, 0, 0, 0, 1}, Vec3(-1), Vec3(1)); }),
            "coefficients: must not all be 0 but for the last: that is no surface");
  EXPECT_EQ(message([&] { return Quadric::of({1, nan}, Vec3(-1), Vec3(1)); }),
            "coefficients[1]: must lie between -1e100 and 1e100, got nan");
  EXPECT_EQ(message([] { return Halfspace::of(Vec3(0), 1); }), "normal: must not be [0, 0, 0]");
  EXPECT_EQ(message([&] { return Halfspace::of(Vec3(0, 1, 0), nan); }), "offset: must lie between -1e100 and 1e100, got nan");
}

TEST(Halfspace, CutsWhatHasAnEnd) {
  SceneBuilder builder;
  uint32_t below = builder.add_solid(Halfspace::of(Vec3(0, 2, 0), 0.25)), ball = builder.add_solid(Sphere{1.0});
  uint32_t cap = builder.add_csg(CsgOperation::Difference, {{ball, Affine{}}, {below, Affine{}}});
  uint32_t all_but_cap = builder.add_csg(CsgOperation::Union, {{below, Affine{}}, {ball, Affine{}}});  // unbounded, cut next
  uint32_t rest = builder.add_csg(CsgOperation::Intersection, {{all_but_cap, Affine{}}, {ball, scale(Vec3(2.0))}});
  auto scene = scene_of(builder, {{cap, Affine{}}, {rest, translate(Vec3(10, 0, 0))}});
  auto along_y = [&](double x) {
    std::vector<Crossing> list;
    crossings(*scene, {Vec3(x, -5, 0), Vec3(0, 1, 0)}, list);
    std::vector<double> out;
    for (const Crossing& c : list) out.push_back(c.t - 5.0);
    return out;
  };
  EXPECT_EQ(along_y(0), (std::vector<double>{0.25, 1}));
  EXPECT_EQ(along_y(10), (std::vector<double>{-2, 1}));
  EXPECT_EQ(along_y(11.5).back(), 0.25);
  Hit hit = closest(*scene, {Vec3(0, -5, 0), Vec3(0, 1, 0)});
  EXPECT_EQ(resolve(*scene, {Vec3(0, -5, 0), Vec3(0, 1, 0)}, hit).normal, Vec3(0, -1, 0));
}

TEST(Halfspace, IsRefusedWhereNothingEndsIt) {
  SceneBuilder builder;
  uint32_t below = builder.add_solid(Halfspace{}), ball = builder.add_solid(Sphere{1.0});
  uint32_t wedge = builder.add_csg(CsgOperation::Intersection, {{below, Affine{}}, {below, rotate(1.0, Vec3(1, 0, 0))}});
  uint32_t without_ball = builder.add_csg(CsgOperation::Difference, {{below, Affine{}}, {ball, Affine{}}});
  for (uint32_t endless : {below, wedge, without_ball}) {
    try {
      builder.add_group({{ball, Affine{}}, {endless, Affine{}}}, "auto");
      FAIL();
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("of[1]: a halfspace has no end"), std::string::npos);
    }
  }
  EXPECT_THROW(builder.build(wedge, {}), Error);
}

TEST(Disk, IsCrossedWithinItsRadiusAndIsOpen) {
  SceneBuilder builder;
  uint32_t disk = builder.add_flat(Disk{2.0}), ball = builder.add_solid(Sphere{1.0});
  try {
    builder.add_csg(CsgOperation::Union, {{ball, Affine{}}, {disk, Affine{}}});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()), "of[1]: a disk is open, and CSG needs closed objects");
  }
  auto scene = scene_of(builder, {{disk, Affine{}}});
  EXPECT_EQ(closest(*scene, {Vec3(1.4, 3, 1.4), Vec3(0, -1, 0)}).t, 3.0);
  EXPECT_FALSE(closest(*scene, {Vec3(1.5, 3, 1.5), Vec3(0, -1, 0)}).found());
  EXPECT_THROW(builder.add_flat(Disk{0.0}), Error);
}

}  // namespace
}  // namespace tilecast
