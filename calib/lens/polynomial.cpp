#include "calib/lens/polynomial.hpp"

#include <algorithm>
#include <cstddef>

namespace kasumi {

double evaluate(const Polynomial& polynomial, double x) {
  double value = 0.0;
  for (std::size_t i = polynomial.size(); i-- > 0;) value = value * x + polynomial[i];
  return value;
}

Polynomial derivative(const Polynomial& polynomial) {
  Polynomial result;
  for (std::size_t i = 1; i < polynomial.size(); ++i) result.push_back(static_cast<double>(i) * polynomial[i]);
  return result;
}

Polynomial sum(const Polynomial& a, const Polynomial& b) {
  Polynomial result(std::max(a.size(), b.size()), 0.0);
  for (std::size_t i = 0; i < a.size(); ++i) result[i] += a[i];
  for (std::size_t i = 0; i < b.size(); ++i) result[i] += b[i];
  return result;
}

Polynomial product(const Polynomial& a, const Polynomial& b) {
  if (a.empty() || b.empty()) return {};
  Polynomial result(a.size() + b.size() - 1, 0.0);
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j) result[i + j] += a[i] * b[j];
  return result;
}

Polynomial scaled(Polynomial polynomial, double factor) {
  for (double& coefficient : polynomial) coefficient *= factor;
  return polynomial;
}

namespace {

// Between the roots of its derivative a polynomial is monotonic, so that each sign change there is one root.
std::vector<double> positive_roots(Polynomial polynomial, double most) {
  while (!polynomial.empty() && polynomial.back() == 0.0) polynomial.pop_back();
  if (polynomial.size() < 2) return {};

  double largest_ratio = 0.0;
  for (const double coefficient : polynomial)
    largest_ratio = std::max(largest_ratio, std::abs(coefficient / polynomial.back()));
  const double beyond_all_roots = std::min(most, 1.0 + largest_ratio);  // Cauchy's bound

  const auto slope = derivative(polynomial);
  auto turns = positive_roots(slope, beyond_all_roots);
  turns.push_back(beyond_all_roots);

  std::vector<double> roots;
  double low = 0.0;
  for (const double high : turns) {
    const double at_low = evaluate(polynomial, low), at_high = evaluate(polynomial, high);
    if ((at_low < 0.0) != (at_high < 0.0)) {
      const double sign = at_high > at_low ? 1.0 : -1.0;
      const double root = solve_increasing([&](double x) { return sign * evaluate(polynomial, x); },
                                           [&](double x) { return sign * evaluate(slope, x); }, 0.0, low, high);
      if (root > 0.0) roots.push_back(root);
    }
    low = high;
  }
  return roots;
}

}  // namespace

std::optional<double> first_positive_root(const Polynomial& polynomial, double most) {
  const auto roots = positive_roots(polynomial, most);
  if (roots.empty()) return std::nullopt;
  return roots.front();
}

}  // namespace kasumi
