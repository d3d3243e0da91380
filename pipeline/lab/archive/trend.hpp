// A trend of monthly values with a sigma that holds for months that resemble their neighbours.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "base/result.hpp"

namespace kasumi {

struct MonthlyValue {
  int month = 0;  // counted from any one
  double value = 0.0;
};

// Least squares of offset, trend and season (a year's wave and half a year's). What is left is taken as autoregressive
// of first order, as of Weatherhead 1998 (J. Geophys. Res. 103, 17149): without gaps and over many years sigma is
// their s (1 + r)^.5 / (1 - r)^.5 / years^1.5 (their eq. 2). Here it is the exact one of this least squares, for the
// months that are there.
struct Trend {
  double per_year = 0.0, sigma = 0.0;
  double autocorrelation = 0.0;  // of a month's rest with the next month's, without the bias of short series
  double sigma_month = 0.0;      // of one month's rest
  double middle = 0.0;           // month at which the value, without season, is `level`
  double level = 0.0;
  std::size_t months = 0;
  double at(double month) const { return level + per_year * (month - middle) / 12.0; }
};

constexpr int kLeastMonthsOfTrend = 24;  // known, and over at least three years
// `values`: months ascending, each once. Errors (bad_input): too few.
Result<Trend> trend_of(const std::vector<MonthlyValue>& values);

}  // namespace kasumi
