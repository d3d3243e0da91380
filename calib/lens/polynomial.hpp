// Polynomials in one variable, and the roots that bound where a lens model holds.
#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <vector>

namespace kasumi {

using Polynomial = std::vector<double>;  // a0 + a1 x + a2 x^2 + ...

double evaluate(const Polynomial& polynomial, double x);
Polynomial derivative(const Polynomial& polynomial);
Polynomial sum(const Polynomial& a, const Polynomial& b);
Polynomial product(const Polynomial& a, const Polynomial& b);
Polynomial scaled(Polynomial polynomial, double factor);

// The smallest x > 0, up to `most`, where the polynomial changes its sign.
std::optional<double> first_positive_root(const Polynomial& polynomial,
                                          double most = std::numeric_limits<double>::infinity());

// The x of [low, high] where a function that increases there takes a value: Newton's steps, and a halving of the
// bracket wherever Newton would leave it or is slow, so that it always arrives.
template <class Function, class Slope>
double solve_increasing(const Function& function, const Slope& slope, double value, double low, double high) {
  double x = 0.5 * (low + high);
  double last_step = high - low;
  for (int i = 0; i < 200; ++i) {
    const double excess = function(x) - value;
    (excess > 0.0 ? high : low) = x;
    const double rise = slope(x);
    double next = x - excess / rise;
    const bool newton_helps = rise > 0.0 && next > low && next < high && std::abs(next - x) < 0.5 * last_step;
    if (!newton_helps) next = 0.5 * (low + high);
    last_step = std::abs(next - x);
    x = next;
    if (last_step <= 1e-16 * std::abs(x) || next == low || next == high) break;
  }
  return x;
}

}  // namespace kasumi
