// The inverse of a 3 x 3 matrix by Cramer's rule, every entry good to a few units in the last place.
//
// Where a matrix is turned and its condition number is large, cofactors and determinant cancel: in double, a condition
// number of 1e8 leaves no digit of the determinant. Two doubles an intermediate result leave 106 bits for that.
// What is singular is told by the condition number in the Frobenius norm, |A| |A^-1|, once the columns have been brought
// to one length: that is within a factor of 3 of the least that any scaling of the columns has (van der Sluis,
// "Condition Numbers and Equilibration of Matrices", Numer. Math. 14, 1969).
#include "base/affine.h"

#include "base/twofold.h"

namespace tilecast {
namespace {

constexpr double kLargestCondition = 1.0 / (16 * kUnitRoundoff);

struct Cofactors {
  Twofold v[3];
};

Cofactors cross(const Vec3& a, const Vec3& b) {
  Cofactors out;
  for (int i = 0; i < 3; ++i) {
    int j = (i + 1) % 3, k = (i + 2) % 3;
    out.v[i] = two_product(a[j], b[k]) + two_product(-a[k], b[j]);
  }
  return out;
}

}  // namespace

InverseAffine inverse(const Affine& m) {
  if (!is_finite(m.linear[0]) || !is_finite(m.linear[1]) || !is_finite(m.linear[2]) || !is_finite(m.offset))
    throw Error("transform has a value that is not finite");
  glm::dmat3 columns;
  int exponents[3];
  for (int i = 0; i < 3; ++i) {
    double largest = max_abs(m.linear[i]);
    if (largest == 0.0) throw Error("transform is singular: it flattens space");
    exponents[i] = std::ilogb(largest);
    for (int j = 0; j < 3; ++j) columns[i][j] = std::ldexp(m.linear[i][j], -exponents[i]);
  }
  Cofactors rows[3] = {cross(columns[1], columns[2]), cross(columns[2], columns[0]), cross(columns[0], columns[1])};
  Twofold determinant;
  for (int j = 0; j < 3; ++j) determinant = determinant + rows[0].v[j] * columns[0][j];
  glm::dmat3 adjugate;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) adjugate[j][i] = rows[i].v[j].value();
  if (!(stretch(columns) * stretch(adjugate) < kLargestCondition * std::fabs(determinant.value())))
    throw Error("transform is singular: it flattens space");
  InverseAffine out{glm::dmat3(1.0), m.offset};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      out.linear[j][i] = std::ldexp(quotient(rows[i].v[j], determinant), -exponents[i]);
      if (!std::isfinite(out.linear[j][i])) throw Error("transform is singular: its inverse is beyond the range of double");
    }
  return out;
}

}  // namespace tilecast
