// Order statistics of a sample and what is robustly told from them: a minority of wrong values does not move these.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

namespace kasumi {

// Of normal deviations: one standard deviation over the median of their sizes, 1 / Phi^-1(3/4).
constexpr double kSigmaOverMedianSize = 1.4826;
// Of deviations in a plane, normal and alike in both coordinates: the median of their lengths over one coordinate's
// standard deviation, sqrt(2 ln 2).
constexpr double kMedianLengthOverSigma = 1.1774;
// The standard error of a large normal sample's median over that of its mean, sqrt(pi / 2).
constexpr double kMedianErrorOverMeanError = 1.2533;
// Where Tukey's weight ends, in standard deviations, for 95 % of the efficiency of least squares on normal deviations.
constexpr double kTukeyReach = 4.685;

// One of the values, never a mean of two, so that whole steps stay whole steps. Of an even number the median is the
// upper of the middle two. Of none it is T{}. The first form moves the values about; no NaN may be among them.
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

// The standard deviation about 0 of normal values among which there are outliers: that of residuals, not of a sample
// whose middle is elsewhere. Of none, 0.
template <std::floating_point T>
T robust_sigma(std::vector<T> residuals) {
  for (T& value : residuals) value = std::abs(value);
  return static_cast<T>(kSigmaOverMedianSize) * median_in_place(residuals);
}

// Tukey's biweight of a residual over the reach at which it ends: 1 at 0, 0 from 1 on.
inline double tukey_weight(double residual_over_reach) {
  const double u = residual_over_reach;
  return std::abs(u) < 1.0 ? (1.0 - u * u) * (1.0 - u * u) : 0.0;
}

}  // namespace kasumi
