#include <gtest/gtest.h>

#include <random>

#include "base/elementary.h"
#include "base/srgb.h"
#include "base/exact.h"
#include "base/frame.h"
#include "base/affine.h"

namespace tilecast {
namespace {

using Quad = __float128;  // 113 bits: products of floats and their difference are exact

TEST(DifferenceOfProducts, HasTheSignOfTheExactDeterminant) {
  std::mt19937 random(1);
  for (int i = 0; i < 1000000; ++i) {
    // Nearly parallel: (c, d) is (a, b) scaled and rounded, in places exactly.
    float a = std::ldexp(static_cast<float>(1 + random() % (1 << 24)), -23), b = std::ldexp(static_cast<float>(1 + random() % (1 << 24)), -23);
    float k = i % 3 == 0 ? 0.5f : static_cast<float>(1 + random() % 1000) / 997.0f;
    float c = a * k, d = b * k;
    if (i % 5 == 0) d = std::nextafter(d, 2.0f);
    Quad exact = Quad(a) * d - Quad(b) * c;
    float computed = difference_of_products(a, d, b, c);
    EXPECT_EQ(exact > 0 ? 1 : exact < 0 ? -1 : 0, computed > 0 ? 1 : computed < 0 ? -1 : 0);
  }
}

TEST(EdgeSign, IsAntisymmetricAndZeroOnlyOnAnEdgeWithoutLength) {
  float values[] = {-2.0f, -1.0f, -0.0f, 0.0f, 1.0f, 3.0f};
  for (float px : values)
    for (float py : values)
      for (float qx : values)
        for (float qy : values) {
          int forward = edge_sign(px, py, qx, qy), backward = edge_sign(qx, qy, px, py);
          EXPECT_EQ(forward, -backward);
          EXPECT_EQ(forward == 0, px == qx && py == qy);
        }
}

TEST(Frame, ScalingByAPowerOfTwoGivesTheSameFloats) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> unit(-1, 1);
  auto point = [&] { return Vec3{unit(random), unit(random), unit(random)}; };
  for (int i = 0; i < 10000; ++i) {
    Box box;
    box.extend(point());
    box.extend(point());
    Ray ray{point() * 3.0, box.centre() - point()};
    int k = static_cast<int>(random() % 81) - 40;
    double s = std::ldexp(1.0, k);
    FrameRay a, b;
    bool in_a = enter_frame(Frame::around(box), ray, a);
    bool in_b = enter_frame(Frame::around({box.lo * s, box.hi * s}), {ray.origin * s, ray.direction}, b);
    ASSERT_EQ(in_a, in_b);
    if (!in_a) continue;
    for (int c = 0; c < 3; ++c) {
      EXPECT_EQ(a.origin[c], b.origin[c]);
      EXPECT_EQ(a.direction[c], b.direction[c]);
    }
    EXPECT_EQ(a.t_start * a.t_scale * s, b.t_start * b.t_scale);
  }
}

TEST(Elementary, AgreesWithLongDouble) {
  for (int i = 0; i <= 100000; ++i) {
    double u = i / 100000.0, s, c;
    sincos_2pi(u, s, c);
    long double angle = 2.0L * 3.14159265358979323846264338327950288L * u;
    EXPECT_NEAR(s, static_cast<double>(std::sin(angle)), 1e-15);
    EXPECT_NEAR(c, static_cast<double>(std::cos(angle)), 1e-15);
    double x = -700.0 * u;
    long double e = std::exp(static_cast<long double>(x));
    EXPECT_NEAR(exp_negative(x), static_cast<double>(e), 2e-15 * static_cast<double>(e));
  }
}

TEST(Elementary, KnowsAnglesInAllQuadrants) {
  const long double full = 2.0L * 3.14159265358979323846264338327950288L;
  for (int i = -100000; i <= 100000; ++i) {
    const double x = std::cos(i * 1e-4) * std::ldexp(1.0, i % 40), y = std::sin(i * 1e-4) * std::ldexp(1.0, i % 40);
    ASSERT_NEAR(atan2_turns(y, x), static_cast<double>(std::atan2(static_cast<long double>(y), static_cast<long double>(x)) / full), 2e-16);
    const double t = i * 1e-9;  // small angles keep their relative precision
    ASSERT_NEAR(atan2_turns(t, 1.0), static_cast<double>(std::atan(static_cast<long double>(t)) / full), 4e-16 * std::fabs(t));
  }
  EXPECT_EQ(atan2_turns(0.0, 0.0), 0.0);
  EXPECT_EQ(atan2_turns(1.0, 0.0), 0.25);
  EXPECT_EQ(atan2_turns(-1.0, 0.0), -0.25);
  EXPECT_EQ(atan2_turns(0.0, -1.0), 0.5);
  EXPECT_EQ(atan2_turns(1e300, 1e300), 0.125);
}

TEST(Elementary, DecodesSrgb) {
  for (int i = 0; i <= 65535; ++i) {
    const float value = static_cast<float>(i / 65535.0);
    const double exact = value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
    ASSERT_NEAR(srgb_to_linear(value), exact, 0x1p-24 * exact * 1.001) << i;
  }
}

TEST(Affine, InvertsTurnedMapsOfConditionNumber1e12) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 1000; ++i) {
    Vec3 x = glm::normalize(Vec3(normal(random), normal(random), normal(random)));
    Vec3 y = glm::normalize(glm::cross(x, Vec3(normal(random), normal(random), normal(random)))), z = glm::cross(x, y);
    glm::dmat3 turn(x, y, z), stretched(x, y * 1e-3, z * 1e-12);
    Affine map{stretched * glm::transpose(turn) * std::ldexp(1.0, i % 400 - 200), Vec3(0.0)};
    InverseAffine back = inverse(map);
    // A A^-1 in 113 bits: the entries of the inverse are good to a few units in the last place.
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) {
        Quad sum = 0, size = 0;
        for (int k = 0; k < 3; ++k) {
          Quad term = Quad(map.linear[k][r]) * back.linear[c][k];
          sum += term;
          size += term < 0 ? -term : term;
        }
        EXPECT_LE(std::fabs(static_cast<double>(sum - (r == c))), 4 * kUnitRoundoff * static_cast<double>(size));
      }
  }
}

TEST(Affine, RefusesWhatFlattensSpaceAtAnyScale) {
  for (double scale : {1e-60, 1.0, 1e60}) {
    Affine flat;
    flat.linear = glm::dmat3(Vec3(1, 2, 3) * scale, Vec3(4, 5, 6) * scale, Vec3(7, 8, 9) * scale);
    EXPECT_THROW(inverse(flat), Error);
    Affine zero_column;
    zero_column.linear = glm::dmat3(Vec3(scale, 0, 0), Vec3(0), Vec3(0, 0, scale));
    EXPECT_THROW(inverse(zero_column), Error);
    Affine fine;
    fine.linear = glm::dmat3(Vec3(scale, 0, 0), Vec3(0, 1e-8 * scale, 0), Vec3(0, 0, scale));
    Vec3 p{1.0, 2.0, 3.0};
    Vec3 back = inverse(fine).point(fine.point(p));
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(back[i], p[i], 1e-14);
  }
  Affine nan;
  nan.linear[1][1] = std::nan("");
  EXPECT_THROW(inverse(nan), Error);
}

}  // namespace
}  // namespace tilecast
