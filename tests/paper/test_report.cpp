// The report of the papers' tables and figures, made with --quick and read back.
#include <cstdlib>
#include <regex>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/outside/json_text.hpp"
#include "tests/paper/report/section.hpp"
#include "tests/places.hpp"

namespace kasumi::paper {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

struct Report {
  std::vector<std::string> ids;
  std::string page;
  nlohmann::json figures;
  double figure(const std::string& section, const std::string& name) const {
    return figures.at(section).at("figures").at(name).get<double>();
  }
  bool skipped(const std::string& section) const {
    return figures.at(section).at("findings").at(0).at("finding") == "skipped";
  }
};
Report made_in_a_hurry() {
  const auto folder = test_output_folder() / "paper-report";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const ReportOptions options{.shared_data = shared_data_folder(), .quick = true};
  const auto sections = all_sections(options);
  EXPECT_TRUE(write_report(folder, sections, options));
  Report report{
      {}, read_text_file(folder / "index.html").value(), parse_json(read_text_file(folder / "figures.json").value())};
  for (const auto& section : sections) report.ids.push_back(section.id());
  return report;
}

// One test, because making the report is slow. Quick figures are held to the papers' printed values and to loose
// limits.
TEST(Report, ShowsThePapersNumbersNextToOursAndIsSelfContained) {
  const auto report = made_in_a_hurry();
  const auto& page = report.page;
  EXPECT_THAT(report.ids, testing::ElementsAre("turbidity", "sky-pictures", "scattering", "terms", "scenes",
                                               "mixed-reality", "photographs", "classic", "landmarks", "haze",
                                               "haze-pictures", "report-u", "frame-rate"));
  for (const auto& id : report.ids) {
    EXPECT_THAT(page, HasSubstr("<section id=\"" + id + "\">"));
    EXPECT_THAT(page, HasSubstr("<a href=\"#" + id + "\">"));
    EXPECT_FALSE(report.figures.at(id).at("findings").empty()) << id;
  }
  EXPECT_THAT(page, AllOf(Not(HasSubstr("<script")), Not(HasSubstr("src=\"http")), Not(HasSubstr("<link")),
                          HasSubstr("data:image/jpeg;base64,"), HasSubstr("<svg "), HasSubstr("</html>")));

  EXPECT_LT(report.figure("turbidity", "worst_bias"), 0.1);
  EXPECT_NEAR(report.figure("turbidity", "worst_bias_of_morales"), 0.0118, 1e-4) << "M Table 1, T = 2, 5, 8";
  EXPECT_THAT(page, HasSubstr("2.012 +- 0.005")) << "M Table 1, T = 2";
  EXPECT_THAT(page, HasSubstr("0.94 %")) << "M14 Table 2, 5 degrees";
  EXPECT_NEAR(report.figure("scattering", "rayleigh_per_km"), 0.0141, 5e-5) << "M Table 2";
  EXPECT_NEAR(report.figure("scattering", "mie_per_km_at_1.6"), 0.0639, 1e-4) << "M Table 2";
  EXPECT_NEAR(report.figure("scattering", "eq5_miss_percent"), 13.3, 0.5) << "M Eq 5 with M's own coefficients";
  EXPECT_NEAR(report.figure("scattering", "fog_begins_at_turbidity"), 19.3, 0.1) << "M Table 2 by M Eq 18";
  EXPECT_NEAR(report.figure("scattering", "morales_over_zhao"), 1.35, 0.02) << "physics 3";
  EXPECT_LT(report.figure("sky-pictures", "figure_7_worst"), 0.3) << "of 120 pixels";
  EXPECT_LT(report.figure("report-u", "table_3_1_worst"), 0.02) << "U Table 3.1";
  EXPECT_GT(report.figure("terms", "direct_zhao_over_ours"), 1.0) << "M14 Fig 7";
  EXPECT_LT(report.figure("terms", "pattern_left.M, Kasumi"), 0.05) << "M Fig 11";
  EXPECT_LT(report.figure("mixed-reality", "error.Kasumi, air found"),
            report.figure("mixed-reality", "error.without aerial perspective"));
  EXPECT_EQ(report.figure("scenes", "comparisons"), 12.0);
  EXPECT_GT(report.figure("scenes", "least_colour_lead"), 0.0);
  EXPECT_THAT(page, HasSubstr("Zhu 2015"));
  EXPECT_LT(report.figure("haze", "rms_matched"), report.figure("haze", "rms_invariant"));
  EXPECT_GT(report.figure("haze", "operations_explicit_over_matched"), 1.0);
  EXPECT_LT(report.figure("haze", "figure_2_worst_percent"), 5.0);
  EXPECT_TRUE(report.skipped("frame-rate"));
  EXPECT_THAT(page, HasSubstr("<b>skipped</b>"));

  const bool photographs = std::filesystem::exists(shared_data_folder() / "haze" / "classic");
  EXPECT_EQ(report.skipped("classic"), !photographs);
  if (!photographs) GTEST_SKIP() << "no hazy photographs next to the checkout; the rest was as expected";
  EXPECT_LT(report.figure("classic", "black_percent_added"), 1.0) << "per cent of the pixels";
  EXPECT_LT(report.figure("classic", "tiananmen.png.top_changed"), 6.0) << "levels of 255: the sky keeps its colour";
}

// A finding that no figure can change is not one: neither its verdict nor its words may be constant.
std::vector<std::string> constant_findings(const std::string& name, const std::string& source) {
  static const std::regex kVerdict(R"(finding\(\s*Finding::(reproduced|better|differs))"),
      kWords(R"re(finding\((?!\s*Finding::skipped)[^;"]*?,\s*(?:[\w.]+ \? )?")re");
  std::vector<std::string> found;
  for (const auto& [pattern, what] : {std::pair{&kVerdict, "verdict"}, {&kWords, "words"}})
    for (std::sregex_iterator at(source.begin(), source.end(), *pattern), last; at != last; ++at)
      found.push_back(fmt::format("{}: constant {}: {}", name, what, at->str()));
  return found;
}

TEST(Report, NoFindingIsAConstant) {
  int sections = 0;
  for (const auto& entry : std::filesystem::directory_iterator(source_folder() / "tests/paper/report")) {
    if (!entry.path().filename().string().ends_with("_section.cpp")) continue;
    ++sections;
    EXPECT_THAT(constant_findings(entry.path().filename(), read_text_file(entry.path()).value()), testing::IsEmpty());
  }
  EXPECT_GE(sections, 8);
  EXPECT_THAT(constant_findings("a", "section.finding(Finding::better, fmt::format(\"{}\", 1));"), testing::SizeIs(1));
  EXPECT_THAT(constant_findings("a", "section.finding(a < b ? Finding::better : Finding::differs, \"ours wins\");"),
              testing::SizeIs(1));
  EXPECT_THAT(constant_findings("a", "section.finding(c ? Finding::better : Finding::differs,\n c ? \"a\" : \"b\");"),
              testing::SizeIs(1));
  EXPECT_THAT(constant_findings("a", "section.finding(Finding::skipped, \"not there.\");"), testing::IsEmpty());
}

TEST(SvgPlot, PlacesPointsByItsAxesAndLabelsItsSeries) {
  const auto svg = svg_of({.title = "a < b",
                           .across = "x",
                           .up = "y",
                           .series = {{.name = "one & two", .points = {{0.0, 0.0}, {10.0, 5.0}}, .marks = true}},
                           .range_across = glm::dvec2{0.0, 10.0},
                           .range_up = glm::dvec2{0.0, 10.0}});
  // 640 x 380 with margins of 64, 16, 34 and 48: x from 64 to 624, y from 332 to 34.
  EXPECT_THAT(svg, AllOf(HasSubstr("M64.0 332.0L624.0 183.0"), HasSubstr("cx=\"624.0\" cy=\"183.0\""),
                         HasSubstr("a &lt; b"), HasSubstr("one &amp; two")));
}

TEST(SvgPlot, OmitsNonPositiveValuesOnALogarithmicAxis) {
  const auto svg = svg_of({.title = "t",
                           .across = "x",
                           .up = "y",
                           .series = {{.name = "s", .points = {{1.0, 0.0}, {1.0, 1.0}, {100.0, 100.0}}}},
                           .log_across = true,
                           .log_up = true,
                           .range_across = glm::dvec2{1.0, 100.0},
                           .range_up = glm::dvec2{1.0, 100.0}});
  EXPECT_THAT(svg, AllOf(HasSubstr("\"M64.0 332.0L624.0 34.0\""), Not(HasSubstr("nan")), Not(HasSubstr("inf"))));
}

}  // namespace
}  // namespace kasumi::paper
