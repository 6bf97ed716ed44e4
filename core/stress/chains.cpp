// Gate 20, and the chains of the extreme scenes: CSG as deep as it is long.
#include <pthread.h>

#include "stress/scenes.h"
#include "stress/stress.h"

namespace tilecast::stress {
namespace {

constexpr int kDeep = 100'000, kShells = 1'000;
constexpr size_t kStack = 256 * 1024;  // bytes

// Runs work() on a thread with a small stack.
template <class Work>
void on_small_stack(Work& work) {
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, kStack);
  pthread_t thread;
  int failed = pthread_create(&thread, &attributes, [](void* p) -> void* {
    (*static_cast<Work*>(p))();
    return nullptr;
  }, &work);
  pthread_attr_destroy(&attributes);
  if (failed) throw Error("no thread with a stack of 256 KiB could be started");
  pthread_join(thread, nullptr);
}

// Balls in a row, each the union of itself and all the balls before: one solid of 100,000 radii.
std::shared_ptr<const Scene> row_of_balls() {
  SceneBuilder builder;
  uint32_t ball = builder.add_solid(Sphere{0.5}), chain = ball;
  for (int i = 1; i <= kDeep; ++i)
    chain = builder.add_csg(CsgOperation::Union, {{ball, translate(Vec3(0.5 * i, 0, 0))}, {chain, Affine{}}});
  return builder.build(chain, {});
}

// Lines along the row meet its two ends; lines across meet the outermost of the three balls there.
double wrong_in_row(uint64_t first, uint64_t count) {
  static std::shared_ptr<const Scene> scene;
  double wrong = 0.0;
  auto work = [&] {
    static const bool built = (scene = row_of_balls(), true);
    std::vector<Crossing> list;
    wrong = sum_over(first, built ? count : 0, [&](auto& random, uint64_t i) {
      std::uniform_real_distribution<double> unit(0, 1);
      double y = 0.2 * unit(random), half = std::sqrt(0.25 - y * y);
      double enter = 5.0 - half, exit = 5.0 + 0.5 * kDeep + half;
      Ray line{Vec3(-5.0, y, 0.0), Vec3(1, 0, 0)};
      if (i % 16 != 0) {  // lines along are slow
        int ball = static_cast<int>(random() % (kDeep + 1));
        line = {Vec3(0.5 * ball, 5.0, y), Vec3(0, -1, 0)};
        enter = 5.0 - half, exit = 5.0 + half;
      }
      crossings(*scene, line, list);
      bool right = list.size() == 2 && list[0].entering && !list[1].entering && std::fabs(list[0].t - enter) < 1e-9 &&
                   std::fabs(list[1].t - exit) < 1e-9;
      return !right;
    });
  };
  on_small_stack(work);
  return wrong;
}

// Concentric balls, each taken from the next larger: A - (B - (C - ...)), shells with gaps between.
std::shared_ptr<const Scene> shells() {
  SceneBuilder builder;
  uint32_t nest = builder.add_solid(Sphere{1.0 / kShells});
  for (int i = 2; i <= kShells; ++i)
    nest = builder.add_csg(CsgOperation::Difference, {{builder.add_solid(Sphere{double(i) / kShells}), Affine{}}, {nest, Affine{}}});
  return builder.build(nest, {});
}

bool shell_is_wrong(Random& random, uint64_t) {
  static const std::shared_ptr<const Scene> scene = shells();
  double offset = std::uniform_real_distribution<double>(0, 1)(random);
  thread_local std::vector<Crossing> list;
  crossings(*scene, {Vec3(-2.0, offset, 0.0), Vec3(1, 0, 0)}, list);
  std::vector<double> expected;
  for (int i = kShells; i > 0 && i > offset * kShells; --i) {
    double r = double(i) / kShells, half = std::sqrt((r - offset) * (r + offset));
    expected.push_back(2.0 - half), expected.push_back(2.0 + half);
  }
  std::sort(expected.begin(), expected.end());
  if (list.size() != expected.size()) return true;
  for (size_t i = 0; i < list.size(); ++i)
    if (list[i].entering != (i % 2 == 0) || std::fabs(list[i].t - expected[i]) > 1e-7) return true;
  return false;
}

}  // namespace

void add_chains(std::vector<Case>& out) {
  out.push_back({"deep-csg", 20, "wrong lines, 100,000 deep on a stack of 256 KiB", 0, Combine::Sum, 512, 100'000,
                 wrong_in_row, 512});
  out.push_back({"csg-chain", 0, "wrong lines, 1,000 shells in each other", 0, Combine::Sum, 512, 1'000'000,
                 sum_of(shell_is_wrong), 64});
}

}  // namespace tilecast::stress
