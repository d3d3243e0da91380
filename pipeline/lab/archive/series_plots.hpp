// Years drawn, each as SVG inside a page, as in archive_plots.hpp.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/lab/archive/photometer.hpp"
#include "pipeline/lab/archive/series_figures.hpp"

namespace kasumi {

// Monthly values with their trend's line.
std::string plot_trend(const std::vector<MonthlyValue>& values, const Trend& trend);
// What became of each month's pictures, as shares.
std::string plot_fates(const SeriesFigures& series);
// A median of each month that has one; empty: fewer than two have.
std::string plot_drift(const SeriesFigures& series, const std::string& title,
                       const std::function<std::optional<double>(const MonthlyTally&)>& value);
// Bland and Altman's: difference over mean of both, their bias and 95 % limits.
std::string plot_agreement(const PhotometerComparison& comparison);

}  // namespace kasumi
