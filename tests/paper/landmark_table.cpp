#include "tests/paper/landmark_table.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numeric>

#include "estimator/landmarks/daylight.hpp"
#include "pipeline/lab/photographs/visibility_series.hpp"
#include "pipeline/site/files/photograph_file.hpp"

namespace kasumi {
namespace {

// Ranks from 1; ties share their mean rank.
std::vector<double> ranks_of(const std::vector<double>& values) {
  std::vector<double> ranks;
  for (const double value : values) {
    const auto below = std::count_if(values.begin(), values.end(), [&](double other) { return other < value; });
    const auto equal = std::count(values.begin(), values.end(), value);
    ranks.push_back(static_cast<double>(below) + 0.5 * (static_cast<double>(equal) + 1.0));
  }
  return ranks;
}

}  // namespace

double spearman(const std::vector<double>& one, const std::vector<double>& other) {
  const auto a = ranks_of(one), b = ranks_of(other);
  const double mean = 0.5 * (static_cast<double>(a.size()) + 1.0);
  double ab = 0.0, aa = 0.0, bb = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ab += (a[i] - mean) * (b[i] - mean);
    aa += (a[i] - mean) * (a[i] - mean);
    bb += (b[i] - mean) * (b[i] - mean);
  }
  return aa > 0.0 && bb > 0.0 ? ab / std::sqrt(aa * bb) : 0.0;
}

Result<LandmarkTable> landmark_table(const std::filesystem::path& folder, const std::filesystem::path& landmarks) {
  std::ifstream list(folder / "visibility.csv");
  if (!list) return fail(FaultKind::bad_input, "{}: expected visibility.csv (name,visibility_m)", folder.string());
  LandmarkTable table;
  std::string line;
  std::getline(list, line);
  while (std::getline(list, line)) {
    const auto comma = line.find(',');
    if (comma == std::string::npos) continue;
    const auto name = line.substr(0, comma);
    const auto photograph = read_photograph(folder / name);
    if (!photograph) return fail(photograph.error());
    LandmarkRow row;
    row.frame = name;
    row.measured_m = std::stod(line.substr(comma + 1));
    const auto reason = why_not_daylight(look_for_daylight(photograph->encoded));
    if (reason.empty())
      table.rows.push_back(std::move(row));
    else
      table.refused.push_back({name, reason});
  }
  std::sort(table.rows.begin(), table.rows.end(),
            [](const auto& one, const auto& other) { return one.measured_m < other.measured_m; });
  std::vector<std::filesystem::path> pictures;
  for (const auto& row : table.rows) pictures.push_back(folder / row.frame);
  const auto scenes = read_visibilities(pictures, landmarks);
  if (!scenes) return fail(scenes.error());
  std::vector<double> ours, measured, best;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    auto& row = table.rows[i];
    const auto& air = scenes->pictures[i].air;
    row.optical_range_m = air.optical_range_m();
    const double by_colours = air.aerosol.per_m + rayleigh_per_m(ScatteringModel::aerosol, 550.0);
    row.colours_m = kMeteorologicalOpticalRange / by_colours;
    row.colours_sigma_m = row.colours_m * std::sqrt(air.aerosol.covariance.per_m) / by_colours;
    const double true_per_m = kMeteorologicalOpticalRange / row.measured_m;
    const auto& readings = scenes->pictures[i].readings;
    row.bound = std::sqrt(scenes->watch.colours().bound(readings, true_per_m, 0.0).per_m) / true_per_m;
    row.tower = readings.front().contrast.g;
    measured.push_back(row.measured_m);
    best.push_back(air.extinction().kind == ExtinctionKind::value ? row.measured_m : 1e9);
    switch (air.extinction().kind) {
      case ExtinctionKind::value:
        row.kind = "value";
        row.sigma_m = air.visibility_sigma_m() * kMeteorologicalOpticalRange / kMeteorologicalRange;
        row.within_1_5 = std::abs(std::log(row.optical_range_m / row.measured_m)) <= std::log(1.5);
        ours.push_back(row.optical_range_m);
        break;
      case ExtinctionKind::at_most:
        row.kind = "visibility at least";
        row.within_1_5 = row.measured_m >= row.optical_range_m;
        ours.push_back(1e9);
        break;
      case ExtinctionKind::at_least:
        row.kind = "visibility at most";
        row.within_1_5 = row.measured_m <= row.optical_range_m;
        ours.push_back(0.0);
        break;
      case ExtinctionKind::nothing:
        row.kind = "nothing";
        ours.push_back(1e9);
        break;
    }
  }
  table.spearman = spearman(ours, measured);
  table.best_spearman = spearman(best, measured);
  return table;
}

}  // namespace kasumi
