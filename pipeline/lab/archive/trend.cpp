#include "pipeline/lab/archive/trend.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include <opencv2/core.hpp>

namespace kasumi {
namespace {

constexpr int kUnknowns = 6;  // offset, trend per year, cosine and sine of a year and of half a year

cv::Mat design_of(const std::vector<MonthlyValue>& values, double middle) {
  cv::Mat design(static_cast<int>(values.size()), kUnknowns, CV_64F);
  for (int i = 0; i < design.rows; ++i) {
    const double month = values[static_cast<std::size_t>(i)].month, year = 2.0 * std::numbers::pi * month / 12.0;
    const double row[kUnknowns]{
        1.0, (month - middle) / 12.0, std::cos(year), std::sin(year), std::cos(2.0 * year), std::sin(2.0 * year)};
    std::copy(std::begin(row), std::end(row), design.ptr<double>(i));
  }
  return design;
}

cv::Mat correlations(const std::vector<MonthlyValue>& values, double of_next) {
  const int n = static_cast<int>(values.size());
  cv::Mat all(n, n, CV_64F);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      all.at<double>(i, j) = std::pow(
          of_next, std::abs(values[static_cast<std::size_t>(i)].month - values[static_cast<std::size_t>(j)].month));
  return all;
}

// Mean product of neighbours over the mean square, by the rests' products.
double ratio_of(const std::vector<MonthlyValue>& values, const cv::Mat& products) {
  double squares = 0.0, neighbours = 0.0;
  int pairs = 0;
  for (int i = 0; i < products.rows; ++i) {
    squares += products.at<double>(i, i);
    if (i == 0 || values[static_cast<std::size_t>(i)].month != values[static_cast<std::size_t>(i - 1)].month + 1)
      continue;
    neighbours += products.at<double>(i, i - 1);
    ++pairs;
  }
  return pairs > 0 && squares > 0.0 ? neighbours / pairs / (squares / products.rows) : 0.0;
}

}  // namespace

Result<Trend> trend_of(const std::vector<MonthlyValue>& values) {
  constexpr int kLeastSpan = 36;
  const int known = static_cast<int>(values.size()),
            span = known > 0 ? values.back().month - values.front().month + 1 : 0;
  if (known < kLeastMonthsOfTrend || span < kLeastSpan)
    return fail(FaultKind::bad_input, "{} months are known within {}: expected at least {} within {}", known, span,
                kLeastMonthsOfTrend, kLeastSpan);
  Trend trend;
  trend.months = values.size();
  trend.middle = 0.5 * (values.front().month + values.back().month);
  const auto design = design_of(values, trend.middle);
  cv::Mat measured(known, 1, CV_64F);
  for (int i = 0; i < known; ++i) measured.at<double>(i) = values[static_cast<std::size_t>(i)].value;
  const cv::Mat solver = (design.t() * design).inv(cv::DECOMP_SVD) * design.t();
  const cv::Mat fitted = solver * measured;
  const cv::Mat rest = measured - design * fitted;
  const cv::Mat to_rest = cv::Mat::eye(known, known, CV_64F) - design * solver;
  // Which autocorrelation makes rests of a fit look like these: the fit takes part of it away.
  const double seen = ratio_of(values, rest * rest.t());
  double low = -0.5, high = 0.95;
  for (int step = 0; step < 12; ++step) {
    const double between = 0.5 * (low + high);
    (ratio_of(values, to_rest * correlations(values, between) * to_rest) < seen ? low : high) = between;
  }
  trend.autocorrelation = 0.5 * (low + high);
  const auto correlated = correlations(values, trend.autocorrelation);
  const double freedom = cv::trace(to_rest * correlated * to_rest)[0];
  const double variance = freedom > 0.0 ? rest.dot(rest) / freedom : 0.0;
  const cv::Mat covariance = solver * correlated * solver.t();
  trend.sigma_month = std::sqrt(variance);
  trend.level = fitted.at<double>(0);
  trend.per_year = fitted.at<double>(1);
  trend.sigma = std::sqrt(variance * covariance.at<double>(1, 1));
  return trend;
}

}  // namespace kasumi
