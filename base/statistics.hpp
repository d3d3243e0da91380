// Order statistics and robust estimates: a minority of wrong values hardly changes them.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

namespace kasumi {

// For normal deviations: standard deviation over median absolute deviation, 1 / Phi^-1(3/4).
constexpr double kSigmaOverMedianSize = 1.4826;
// For two-dimensional isotropic normal deviations: median length over the standard deviation of one coordinate, sqrt(2
// ln 2).
constexpr double kMedianLengthOverSigma = 1.1774;
// The standard error of a large normal sample's median over that of its mean, sqrt(pi / 2).
constexpr double kMedianErrorOverMeanError = 1.2533;
// Where Tukey's weight reaches 0, in standard deviations, for 95 % efficiency on normal deviations.
constexpr double kTukeyReach = 4.685;

// Always one of the values, never a mean of two, so that integers stay integers. For an even count it is the upper of
// the middle two; for none, T{}. The first form reorders the values. No value may be NaN.
template <class T>
T median_in_place(std::vector<T>& values) {
  if (values.empty()) return T{};
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}
template <class T>
T median(std::vector<T> values) {
  return median_in_place(values);
}

// The value at floor(share (n - 1)) in ascending order of `projection`; share in 0..1. Of none, T{}. A quantile of .5
// is the lower of the middle two of an even number, where `median` is the upper.
template <class T, class Projection = std::identity>
T quantile_in_place(std::vector<T>& values, double share, Projection projection = {}) {
  if (values.empty()) return T{};
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, nth, {}, projection);
  return *nth;
}
template <class T, class Projection = std::identity>
T quantile(std::vector<T> values, double share, Projection projection = {}) {
  return quantile_in_place(values, share, std::move(projection));
}

// The standard deviation about 0 of normal values with outliers; for residuals, not for samples with another mean. 0
// for none.
template <std::floating_point T>
T robust_sigma(std::vector<T> residuals) {
  for (T& value : residuals) value = std::abs(value);
  return static_cast<T>(kSigmaOverMedianSize) * median_in_place(residuals);
}

// Tukey's biweight of a residual divided by its cutoff: 1 at 0, 0 from 1 on.
inline double tukey_weight(double residual_over_reach) {
  const double u = residual_over_reach;
  return std::abs(u) < 1.0 ? (1.0 - u * u) * (1.0 - u * u) : 0.0;
}

}  // namespace kasumi
