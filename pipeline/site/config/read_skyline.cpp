#include "pipeline/site/config/read_skyline.hpp"

#include <cmath>
#include <vector>

#include <fmt/ranges.h>

#include "pipeline/site/files/csv_table.hpp"

namespace kasumi {

namespace {

using Points = std::vector<Skyline::Point>;

// Two heights in one direction; a last row that closes the circle is none.
void refuse_rivals(const std::filesystem::path& file, const Points& points, Problems& problems) {
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const double apart = std::remainder(points[i].azimuth_deg - points[j].azimuth_deg, 360.0);
      if (std::abs(apart) > 1e-6 || points[i].elevation_deg == points[j].elevation_deg) continue;
      problems.add("{}: elevation_deg = {:g} and {:g} at azimuth_deg = {:g}: expected one", file.string(),
                   points[j].elevation_deg, points[i].elevation_deg, points[i].azimuth_deg);
    }
}

Points read_points(const std::filesystem::path& file, Problems& problems) {
  const auto table = CsvTable::read(file, problems);
  const auto azimuth = table.column("azimuth_deg"), elevation = table.column("elevation_deg");
  for (const auto& [column, name] : {std::pair{azimuth, "azimuth_deg"}, std::pair{elevation, "elevation_deg"}})
    if (!column && !table.names().empty()) problems.add("{}:1: column {} is missing", file.string(), name);
  Points points;
  if (!azimuth || !elevation) return points;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const auto at = table.number(row, *azimuth, -360.0, 360.0, problems);
    const auto height = table.number(row, *elevation, -10.0, 90.0, problems);
    if (at && height) points.push_back({*at, *height});
  }
  constexpr std::size_t kFewest = 2, kMost = 3600;
  if (table.rows() < kFewest || table.rows() > kMost)
    problems.add("{}: {} rows: expected {} to {}", file.string(), table.rows(), kFewest, kMost);
  else
    refuse_rivals(file, points, problems);
  return points;
}

}  // namespace

Skyline read_skyline(const ConfigTable& object) {
  const auto file = object.optional_file("skyline");
  std::error_code missing;  // which the table has reported
  if (!file || !std::filesystem::is_regular_file(*file, missing)) return {};
  Problems problems;
  auto points = read_points(*file, problems);
  if (problems.empty()) return Skyline(std::move(points));
  constexpr std::size_t kShown = 10;
  auto lines = problems.lines();
  const auto all = lines.size();
  if (all > kShown) {
    lines.resize(kShown);
    lines.push_back(fmt::format("and {} more", all - kShown));
  }
  object.problem("skyline", fmt::format("a table of azimuth_deg and elevation_deg:\n  {}", fmt::join(lines, "\n  ")));
  return {};
}

}  // namespace kasumi
