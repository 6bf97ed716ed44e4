#include "geometry/polynomial.h"

#include <algorithm>

#include "base/vec.h"

namespace tilecast {
namespace {

// The derivative of a polynomial, both of them lowest power first, in double.
template <size_t N>
std::array<double, N - 1> derivative(const std::array<double, N>& p) {
  std::array<double, N - 1> out;
  for (size_t i = 1; i < N; ++i) out[i - 1] = static_cast<double>(i) * p[i];
  return out;
}

struct Value {
  double value, slope;
};

template <size_t N>
Value evaluate(const std::array<double, N>& p, double s) {
  double value = p[N - 1], slope = 0.0;
  for (size_t i = N - 1; i-- > 0;) {
    slope = std::fma(slope, s, value);
    value = std::fma(value, s, p[i]);
  }
  return {value, slope};
}

// The slope of a root only steers Newton's method: double is enough there.
Value evaluate(const Quartic& p, double s) {
  Twofold value = p[4];
  double slope = 0.0;
  for (size_t i = 4; i-- > 0;) {
    slope = std::fma(slope, s, value.hi);
    value = value * s + p[i];
  }
  return {value.value(), slope};
}

// The root in low .. high, at whose ends the signs differ; `rises`: the sign at `high` is positive.
template <class P>
double root_between(const P& p, double low, double high, bool rises, double guess) {
  double s = low < guess && guess < high ? guess : 0.5 * low + 0.5 * high;
  for (int i = 0; i < 200; ++i) {  // bisection alone needs fewer
    Value at = evaluate(p, s);
    if (at.value == 0.0) return s;
    ((at.value > 0.0) == rises ? high : low) = s;
    double next = s - at.value / at.slope;
    if (next == s) return s;
    // A step that is below the last digit leads out of the bracket by rounding alone.
    if (!(low < next && next < high)) next = 0.5 * low + 0.5 * high;
    if (next == low || next == high) return s;
    s = next;
  }
  return s;
}

// The roots of p in low .. high, given those of its derivative: between two of them p is monotone. Where a sign change
// is within rounding it may be missed or made up; the next polynomial's values there hardly differ.
template <size_t N>
int roots_between(const std::array<double, N>& p, double low, double high, const double* extrema, int count,
                  double* out) {
  int found = 0;
  double from = low;
  bool before = evaluate(p, from).value > 0.0;
  for (int i = 0; i <= count; ++i) {
    double to = i < count ? extrema[i] : high;
    bool after = evaluate(p, to).value > 0.0;
    if (before != after) out[found++] = root_between(p, from, to, after, 0.5 * from + 0.5 * to);
    from = to;
    before = after;
  }
  return found;
}

}  // namespace

int negative_between(const Quartic& p, double low, double high, Twofold out[4]) {
  std::array<double, 5> rounded;
  for (int i = 0; i < 5; ++i) rounded[i] = p[i].value();
  std::array<double, 4> first = derivative(rounded);
  std::array<double, 3> second = derivative(first);
  std::array<double, 2> third = derivative(second);
  double bends[1], flats[2], extrema[3];
  int count = roots_between(third, low, high, nullptr, 0, bends);
  count = roots_between(second, low, high, bends, count, flats);
  count = roots_between(first, low, high, flats, count, extrema);

  int found = 0;
  double from = low;
  bool before = true;
  for (int i = 0; i <= count; ++i) {
    double to = i < count ? extrema[i] : high;
    bool after = i == count || evaluate(p, to).value > 0.0;
    if (before != after) {
      double guess = root_between(rounded, from, to, after, 0.5 * from + 0.5 * to);
      double root = root_between(p, from, to, after, guess);
      Value at = evaluate(p, root);
      double rest = -at.value / at.slope;
      bool last_digit = std::fabs(rest) <= 0x1p-52 * std::fabs(root);  // not where it touches
      out[found++] = {root, last_digit ? rest : 0.0};
    }
    from = to;
    before = after;
  }
  return found;
}

double root_error(const Quartic& p, double root, double perturbation, double most) {
  double c[5];  // Taylor's coefficients at the root
  for (int i = 0; i < 5; ++i) c[i] = p[i].value();
  for (int k = 0; k < 4; ++k)
    for (int i = 3; i >= k; --i) c[i] = std::fma(c[i + 1], root, c[i]);
  double error = std::min(2.0 * perturbation / std::fabs(c[1]), std::sqrt(2.0 * perturbation / std::fabs(c[2])));
  while (error < most) {
    // At root +- error the quartic is beyond the perturbation, by one of the terms, whatever the others do.
    double term[5], sum = 0.0, power = 1.0;
    for (int k = 1; k < 5; ++k) sum += term[k] = std::fabs(c[k]) * (power *= error);
    for (int k = 1; k < 5; ++k)
      if (term[k] >= 1.9 * perturbation && 2.0 * term[k] - sum >= perturbation) return error;
    error *= 2.0;
  }
  return most;
}

}  // namespace tilecast
