// Gates 19 and 21: random CSG trees against two exact answers: an algebra of intervals, and membership of points.
#include "shading/medium.h"
#include "stress/scenes.h"
#include "stress/stress.h"

namespace tilecast::stress {
namespace {

using Quad = __float128;

// What a tree is made of, beside the core's own flattened one.
struct Tree {
  CsgOperation operation = CsgOperation::Union;
  std::vector<Tree> of;  // none: an operand
  uint32_t operand = 0;  // numbered in the order of the tree, as the core does
};

struct TreeScene {
  Tree tree;
  std::shared_ptr<const Scene> scene;
  const Csg* csg;
};

struct Growing {
  SceneBuilder builder;
  Random random;
  int material;
  uint32_t solids[4];
  uint32_t operands = 0;
};

// Operands spread over all children; every object is of about unit size.
std::pair<uint32_t, Tree> grow(Growing& g, int leaves) {
  if (leaves == 1) return {g.solids[g.random() % 4], Tree{CsgOperation::Union, {}, g.operands++}};
  Tree tree;
  tree.operation = static_cast<CsgOperation>(g.random() % 3);
  int children = leaves == 2 ? 2 : 2 + g.random() % 2;
  std::vector<InstanceSource> operands;
  for (int i = 0; i < children; ++i) {
    int share = i + 1 < children ? leaves / children : leaves - (children - 1) * (leaves / children);
    auto [object, part] = grow(g, share);
    operands.push_back({object, random_affine(g.random)});
    tree.of.push_back(std::move(part));
  }
  return {g.builder.add_csg(tree.operation, operands), tree};
}

std::vector<TreeScene> forest(int trees, int leaves) {
  std::vector<TreeScene> out;
  for (int i = 0; i < trees; ++i) {
    Growing g{{}, Random(19 + i), 0, {}};
    Material glass;
    glass.kind = MaterialKind::Dielectric;
    g.material = g.builder.add_material(glass);
    g.solids[0] = g.builder.add_solid(Sphere{0.8});
    g.solids[1] = g.builder.add_solid(Block{Vec3(-0.7), Vec3(0.7)});
    g.solids[2] = g.builder.add_solid(Cylinder{0.5, 1.4});
    g.solids[3] = g.builder.add_mesh(gridded_cube(2).transformed(0.625, Vec3(0)).build(), "auto");  // exact in float
    auto [root, tree] = grow(g, leaves);
    auto scene = scene_of(g.builder, {{root, Affine{}, g.material}});
    out.push_back({tree, scene, &scene->csgs[scene->objects[root].index]});
  }
  return out;
}

// --- Gate 19: intervals, merged as Roth did.

using Ends = std::vector<double>;  // sorted, entries and exits in turn

// Replaces `a` by the two combined; `out` is scratch.
void combine(CsgOperation operation, Ends& a, const Ends& b, Ends& out) {
  out.clear();
  size_t i = 0, k = 0;
  while (i < a.size() || k < b.size()) {
    double t = k == b.size() || (i < a.size() && a[i] <= b[k]) ? a[i] : b[k];
    while (i < a.size() && a[i] == t) ++i;
    while (k < b.size() && b[k] == t) ++k;
    bool in_a = i & 1, in_b = k & 1;
    bool inside = operation == CsgOperation::Union          ? in_a || in_b
                  : operation == CsgOperation::Intersection ? in_a && in_b
                                                            : in_a && !in_b;
    if (inside != (out.size() & 1)) out.push_back(t);
  }
  a.swap(out);
}

// The spans of a node, into `ends[depth]`; below it lie those of its children.
void evaluate(const Tree& tree, const std::vector<Ends>& operands, std::vector<Ends>& ends, size_t depth = 0) {
  if (ends.size() < depth + 2) ends.resize(depth + 2);
  if (tree.of.empty()) {
    ends[depth] = operands[tree.operand];
    return;
  }
  thread_local Ends scratch;
  evaluate(tree.of[0], operands, ends, depth);
  for (size_t i = 1; i < tree.of.size(); ++i) {
    evaluate(tree.of[i], operands, ends, depth + 1);
    combine(tree.operation, ends[depth], ends[depth + 1], scratch);
  }
}

// What lies between crossings that the error bounds leave in no order, which are one event to the core: see scene/csg.h. Only
// those of meshes, which float decides, are farther from each other than 8 u.
double left_open(std::vector<Crossing>& all) {
  std::sort(all.begin(), all.end(), [](const Crossing& a, const Crossing& b) { return a.t < b.t; });
  double open = 0.0;
  for (size_t k = 1; k < all.size(); ++k)
    if (double gap = all[k].t - all[k - 1].t; gap <= all[k].error + all[k - 1].error) open += gap;
  return open;
}

// The difference of the measures inside, over the farthest crossing, in 8 u, but for what is left open; infinity where
// spans are out of order.
double measure_error(Random& random, uint64_t i) {
  static const std::vector<TreeScene> trees = forest(32, 33);
  const TreeScene& tree = trees[i % trees.size()];
  Ray line = random_ray(random, 4.0);
  thread_local std::vector<Crossing> found, all;
  crossings(*tree.scene, line, found);
  double measure = 0.0, exact = 0.0, farthest = 1e-300;
  for (size_t k = 0; k < found.size(); ++k) {
    if (found[k].entering != (k % 2 == 0) || (k > 0 && !(found[k - 1].t < found[k].t))) return kInfinity;
    measure += found[k].entering ? -found[k].t : found[k].t;
  }
  if (found.size() % 2) return kInfinity;
  thread_local std::vector<Ends> operands, spans;  // which keep their memory
  operands.resize(tree.csg->assembly.instances.size());
  all.clear();
  for (size_t i = 0; i < operands.size(); ++i) {
    const Instance& operand = tree.csg->assembly.instances[i];
    const size_t begin = all.size();
    crossings(*tree.scene, tree.scene->objects[operand.object], operand.local(line), 0, all);
    Ends& ends = operands[i];
    ends.clear();
    for (size_t k = begin; k < all.size(); ++k) ends.push_back(all[k].t), farthest = std::max(farthest, std::fabs(all[k].t));
    std::sort(ends.begin(), ends.end());
  }
  evaluate(tree.tree, operands, spans);
  const Ends& ends = spans.front();
  for (size_t k = 0; k < ends.size(); ++k) exact += k % 2 ? ends[k] : -ends[k];
  const double off = std::fabs(measure - exact), unit = 8 * kUnitRoundoff * farthest;
  return (off <= unit ? off : std::max(off - left_open(all), 0.0)) / unit;
}

// --- Gate 21: points.

// Positive inside, negative outside; T is double, or Quad where that is too near to zero.
template <class T>
T depth_inside(const Scene& scene, const Object& object, const T p[3]) {
  auto magnitude = [](T x) { return x < T(0) ? -x : x; };
  auto in_block = [&](T half) {
    return half - std::max({magnitude(p[0]), magnitude(p[1]), magnitude(p[2])});
  };
  if (object.kind == Kind::Mesh) return in_block(T(0.625));
  const Solid& solid = scene.solids[object.index];
  if (auto* s = std::get_if<Sphere>(&solid)) return T(s->radius) * T(s->radius) - (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
  if (auto* c = std::get_if<Cylinder>(&solid))
    return std::min(T(c->radius) * T(c->radius) - (p[0] * p[0] + p[2] * p[2]), T(0.5) * T(c->height) - magnitude(p[1]));
  return in_block(T(std::get<Block>(solid).hi.x));
}

// Cramer's rule in the wide type.
bool inside_exactly(const Scene& scene, const Instance& operand, const Vec3& point) {
  Quad m[3][3], d[3], local[3];
  for (int r = 0; r < 3; ++r) {
    d[r] = Quad(point[r]) - operand.to_parent.offset[r];
    for (int c = 0; c < 3; ++c) m[r][c] = operand.to_parent.linear[c][r];
  }
  auto determinant = [](const Quad a[3][3]) {
    return a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) - a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0]) +
           a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
  };
  for (int c = 0; c < 3; ++c) {
    Quad replaced[3][3];
    for (int r = 0; r < 3; ++r)
      for (int k = 0; k < 3; ++k) replaced[r][k] = k == c ? d[r] : m[r][k];
    local[c] = determinant(replaced) / determinant(m);
  }
  return depth_inside(scene, scene.objects[operand.object], local) > 0;
}

bool inside(const TreeScene& tree, const Tree& node, const Vec3& point) {
  if (node.of.empty()) {
    const Instance& operand = tree.csg->assembly.instances[node.operand];
    Vec3 local = operand.to_local.point(point);
    double coordinates[3] = {local.x, local.y, local.z};
    double depth = depth_inside(*tree.scene, tree.scene->objects[operand.object], coordinates);
    return std::fabs(depth) > 1e-9 ? depth > 0.0 : inside_exactly(*tree.scene, operand, point);
  }
  bool result = inside(tree, node.of[0], point);
  for (size_t i = 1; i < node.of.size(); ++i) {
    if (node.operation == CsgOperation::Union ? result : !result) break;
    bool part = inside(tree, node.of[i], point);
    result = node.operation == CsgOperation::Difference ? !part : part;
  }
  return result;
}

bool occupancy_is_wrong(Random& random, uint64_t i) {
  static const std::vector<TreeScene> trees = forest(32, 12);
  const TreeScene& tree = trees[i % trees.size()];
  std::uniform_real_distribution<double> unit(-1.5, 1.5);
  Vec3 origin{unit(random), unit(random), unit(random)};
  bool exact = inside(tree, tree.tree, origin);
  Ray line{origin, random_direction(random)};
  thread_local std::vector<Crossing> list;
  crossings(*tree.scene, line, list);
  int depth = 0;
  for (const Crossing& c : list)
    if (c.t <= 0.0) depth += c.entering ? 1 : -1;
  Hit hit = closest(*tree.scene, line);
  bool media = media_at(*tree.scene, origin).current() != nullptr;
  return depth != int(exact) || media != exact || (hit.found() ? hit.entering == exact : exact);
}

}  // namespace

void add_trees(std::vector<Case>& out) {
  out.push_back({"csg-trees", 19, "measure of the spans against interval algebra, in 8 u of t", 1, Combine::Max, 1'000'000,
                 1'000'000'000, worst_of(measure_error)});
  out.push_back({"camera-inside", 21, "origins whose occupancy is wrong", 0, Combine::Sum, 1'000'000, 100'000'000,
                 sum_of(occupancy_is_wrong)});
}

}  // namespace tilecast::stress
