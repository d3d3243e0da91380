#include <algorithm>

#include <fmt/format.h>

#include "tests/paper/landmark_table.hpp"
#include "tests/paper/report/section.hpp"
#include "tests/places.hpp"

namespace kasumi::paper {

Section landmarks_section(const ReportOptions& options) {
  Section section("landmarks", "Visibility from landmarks: not in the papers");
  section.say(
      "A second way to the air, independent of the sky's turbidity: how much contrast landmarks at known distance have "
      "left. KNMI's meadow at De Bilt, whose visibility (where 5 % of contrast is left) is measured next to the "
      "camera; distances from published places and the camera's geometry, nothing fitted to a visibility; the "
      "contrasts without air are learnt from the other pictures.");
  const auto folder = options.shared_data / "haze" / "knmi-debilt";
  if (!std::filesystem::exists(folder)) {
    section.finding(Finding::skipped, fmt::format("{}: not there.", folder.string()));
    return section;
  }
  const auto table = landmark_table(folder, source_folder() / "tests" / "paper" / "knmi-debilt.toml");
  if (!table) {
    section.finding(Finding::skipped, table.error().message);
    return section;
  }
  const auto km = [](double metres) { return fmt::format("{:.3g} km", metres / 1000.0); };
  std::vector<std::vector<std::string>> rows;
  Plot plot{.title = "Visibility of De Bilt's daylight pictures",
            .across = "measured, km",
            .up = "from landmarks, km",
            .series = {{.name = "values", .line = false, .marks = true},
                       {.name = "bounds", .line = false, .marks = true},
                       {.name = "as measured"},
                       {.name = "factor 1.5", .dashed = true},
                       {.name = "factor 1.5", .dashed = true}},
            .log_across = true,
            .log_up = true,
            .range_across = glm::dvec2{0.05, 100.0},
            .range_up = glm::dvec2{0.05, 100.0}};
  int between = 0, within = 0;
  for (const auto& row : table->rows) {
    const bool value = row.kind == "value";
    rows.push_back({row.frame, km(row.measured_m),
                    row.kind == "value" ? km(row.optical_range_m) + " +- " + km(row.sigma_m)
                                        : row.kind + " " + km(row.optical_range_m),
                    fmt::format("{:.2f}", row.optical_range_m / row.measured_m), row.within_1_5 ? "yes" : "no"});
    plot.series[value ? 0 : 1].points.emplace_back(row.measured_m / 1000.0, row.optical_range_m / 1000.0);
    if (row.measured_m < 300.0 || row.measured_m > 10e3) continue;
    ++between;
    within += row.within_1_5;
  }
  for (const double v : {0.05, 100.0}) {
    plot.series[2].points.emplace_back(v, v);
    plot.series[3].points.emplace_back(v, 1.5 * v);
    plot.series[4].points.emplace_back(v, v / 1.5);
  }
  section.table({"frame", "measured", "from landmarks", "ratio", "within 1.5, or a bound that holds"}, rows);
  section.plot(plot);
  section.figure("spearman", table->spearman);
  section.figure("between_300_m_and_10_km", between);
  section.figure("within_1.5", within);
  section.finding(
      table->spearman >= 0.9 ? Finding::better : Finding::differs,
      fmt::format("ranks the pictures with Spearman {:.2f}; {} of {} between .3 and 10 km are within a factor 1.5, "
                  "or bounds that hold: landmarks 110 to 350 m away cannot tell 10 km from 50.",
                  table->spearman, within, between));
  return section;
}

}  // namespace kasumi::paper
