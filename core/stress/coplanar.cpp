// Gate 18: two cubes with faces in one plane, in 54 arrangements. No line shows a speckle.
//
// The exact answer is that of set operations on closed intervals with what has no inside left out: crossings at one
// plane are one event. Where both cubes end at that plane, the surface is the first operand's.
#include "stress/scenes.h"
#include "stress/stress.h"

namespace tilecast::stress {
namespace {

// Near an edge, a line may meet two planes within the error bounds of their crossings: then they are one to it. A mesh's
// faces may be off sideways by 2^-22 of its frame, and a crossing moves by that over the sine of the angle that the line
// makes with the plane.
constexpr double kSideways = 1e-6;

struct Arrangement {
  CsgOperation operation;
  Vec3 centre;    // of the second cube; the first is [-1, 1]^3
  double half;    // its half size
  std::shared_ptr<const Scene> scene;
  Affine placed;  // the whole
  uint64_t first_primitives;  // those of the first operand come before this
};

// A quarter turn with the rounding that sin and cos leave in it.
Affine quarter_turn(int axis) {
  Vec3 v(0.0);
  v[axis] = 1.0;
  return rotate(0.5 * kPi, v);
}

const std::vector<Arrangement>& arrangements() {
  static const std::vector<Arrangement> all = [] {
    Random random(18);
    struct Placement {
      Vec3 centre;
      double half;
    } placements[] = {{Vec3(0, 0, 0), 1.0},     {Vec3(2, 0, 0), 1.0},       {Vec3(1, 0, 0), 1.0},
                      {Vec3(1, 1, 0), 1.0},     {Vec3(0.5, 0.5, 0.5), 0.5}, {Vec3(0, 0, -0.75), 0.25}};
    std::vector<Arrangement> out;
    for (CsgOperation operation : {CsgOperation::Union, CsgOperation::Intersection, CsgOperation::Difference})
      for (int shapes = 0; shapes < 3; ++shapes)
        for (const Placement& p : placements) {
          SceneBuilder builder;
          uint32_t a = shapes < 2 ? builder.add_solid(Block{Vec3(-1), Vec3(1)}) : builder.add_mesh(gridded_cube(3).build(), "auto");
          // The second cube gets its size and place from a map, and is turned by a quarter: planes meet up to rounding.
          uint32_t b = shapes < 1 ? builder.add_solid(Block{Vec3(-0.25), Vec3(0.25)})
                                  : builder.add_mesh(gridded_cube(2).transformed(0.25, Vec3(0)).build(), "auto");
          Affine to_place = translate(p.centre) * quarter_turn(static_cast<int>(out.size() % 3)) *
                            scale(Vec3(p.half / 0.25));
          // Both operands turned likewise, some far away, and then the whole: coordinates are rounded at every level.
          Affine turn = translate((out.size() % 2 ? 1e5 : 1.0) * random_direction(random)) *
                        rotate(0.7 + out.size(), random_direction(random));
          uint32_t csg = builder.add_csg(operation, {{a, turn}, {b, turn * to_place}});
          Affine placed = random_affine(random);
          auto scene = scene_of(builder, {{csg, placed}});
          uint64_t first = scene->objects[a].primitives;
          out.push_back({operation, p.centre, p.half, scene, placed * turn, first});
        }
    return out;
  }();
  return all;
}

// Where a line meets a plane, and within which distance it cannot tell it from others.
struct Meeting {
  long double t;
  double near;
};

struct Wall : Meeting {
  bool of_a, of_b;  // whose boundary it is
};

// A line and a cube: its six planes, and the interval inside.
struct Passage {
  Meeting planes[6];
  Meeting enter{-kInfinity, 0.0}, exit{kInfinity, 0.0};

  Passage(const Ray& line, const Vec3& centre, double half) {
    for (int i = 0; i < 3; ++i) {
      Meeting* pair = &planes[2 * i];
      for (int side = 0; side < 2; ++side) {
        long double plane = static_cast<long double>(centre[i]) + (side ? half : -half);
        pair[side] = {(plane - line.origin[i]) / line.direction[i], kSideways / std::fabs(line.direction[i])};
      }
      if (pair[0].t > pair[1].t) std::swap(pair[0], pair[1]);
      if (pair[0].t > enter.t) enter = pair[0];
      if (pair[1].t < exit.t) exit = pair[1];
    }
  }
  bool inside() const { return enter.t < exit.t; }
  // Whether the ends of another's interval, or its own, are one with these planes or well away from them.
  bool clear_of(const Passage& other) const {
    for (const Meeting& m : planes)
      for (const Meeting& end : {other.enter, other.exit})
        if (m.t != end.t && std::abs(m.t - end.t) <= m.near + end.near) return false;
    return true;
  }
};

bool speckles(Random& random, uint64_t i) {
  const Arrangement& a = arrangements()[i % arrangements().size()];
  std::uniform_real_distribution<double> unit(-1, 1);
  Vec3 through{1.5 * unit(random), 1.5 * unit(random), 1.5 * unit(random)}, direction = random_direction(random);
  if (i / 54 % 4 == 0) {  // near to an axis: lines that graze the other faces
    int axis = static_cast<int>(random() % 3);
    for (int k = 0; k < 3; ++k)
      if (k != axis) direction[k] *= 1e-3;
  }
  direction = glm::normalize(direction);
  Ray line{through - 6.0 * direction, direction};
  Passage of_a(line, Vec3(0.0), 1.0), of_b(line, a.centre, a.half);
  if (!of_a.clear_of(of_a) || !of_a.clear_of(of_b) || !of_b.clear_of(of_a) || !of_b.clear_of(of_b)) return false;

  std::vector<Wall> walls;
  auto wall = [&](const Meeting& at, bool first) {
    for (Wall& w : walls)
      if (w.t == at.t) {  // one plane: all coordinates are exact
        (first ? w.of_a : w.of_b) = true;
        return;
      }
    walls.push_back({at, first, !first});
  };
  if (of_a.inside()) wall(of_a.enter, true), wall(of_a.exit, true);
  if (of_b.inside()) wall(of_b.enter, false), wall(of_b.exit, false);
  std::sort(walls.begin(), walls.end(), [](const Wall& x, const Wall& y) { return x.t < y.t; });
  bool a_inside = false, b_inside = false, inside = false;
  thread_local std::vector<Crossing> found;
  crossings(*a.scene, {a.placed.point(line.origin), a.placed.vector(line.direction)}, found);
  size_t next = 0;
  for (const Wall& w : walls) {
    a_inside ^= w.of_a;
    b_inside ^= w.of_b;
    bool now = a.operation == CsgOperation::Union          ? a_inside || b_inside
               : a.operation == CsgOperation::Intersection ? a_inside && b_inside
                                                           : a_inside && !b_inside;
    if (now == inside) continue;
    inside = now;
    if (next == found.size()) return true;
    const Crossing& c = found[next++];
    bool first_operand = c.primitive < a.first_primitives;
    if (c.entering != now || std::fabs(c.t - static_cast<double>(w.t)) > w.near || first_operand != w.of_a) return true;
  }
  return next != found.size();
}

}  // namespace

void add_coplanar(std::vector<Case>& out) {
  out.push_back({"coplanar-csg", 18, "lines that show a speckle, 54 arrangements", 0, Combine::Sum, 1'000'000, 100'000'000,
                 sum_of(speckles)});
}

}  // namespace tilecast::stress
