// kasumi estimate --csv: the values of --json as a table.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include <nlohmann/json.hpp>

#include "base/outside/json_text.hpp"
#include "base/utc_text.hpp"
#include "pipeline/lab/archive/estimate_csv.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/run_kasumi.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

// By RFC 4180, as its readers do: rows of cells.
std::vector<std::vector<std::string>> rows_of(const std::string& text) {
  std::vector<std::vector<std::string>> rows;
  std::vector<std::string> row(1);
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted && c == '"' && i + 1 < text.size() && text[i + 1] == '"') {
      row.back() += text[++i];
    } else if (c == '"') {
      quoted = !quoted;
    } else if (!quoted && c == ',') {
      row.emplace_back();
    } else if (!quoted && c == '\n') {
      rows.push_back(std::exchange(row, std::vector<std::string>(1)));
    } else {
      row.back() += c;
    }
  }
  EXPECT_FALSE(quoted);
  return rows;
}

constexpr const char* kHeader =
    "image,utc,usable,turbidity,sigma,aod_550,sigma_aod_550,angstrom_exponent,visibility_m,sky,cloud_fraction,"
    "sigma_cloud_fraction,sun_zenith_deg,sun_azimuth_deg,sun_sigma_deg,circle_x,circle_y,circle_r,reason\n";

// Scripts know the columns by name and by place.
TEST(EstimateCsv, TheColumnsAreStable) {
  EXPECT_EQ(estimate_csv_header(), kHeader);
}

TEST(EstimateCsv, ValuesAreThoseOfTheAnswer) {
  const auto line = estimate_csv_line(
      R"({"image":"a.jpg","turbidity":2.4904,"sigma":0.2,"usable":true,"reason":"","sky":"clear","cloud_fraction":0.25,)"
      R"("sigma_cloud_fraction":0.125,"sun_zenith_deg":66.3224,"sun_azimuth_deg":237.5,"sun_sigma_deg":0.5,)"
      R"("aod_550":0.15,"sigma_aod_550":0.013,"angstrom_exponent":1.3,"visibility_m":59859.0,"circle":[9.5,8.25,7]})",
      parse_utc("2026-10-20T06:10:05Z"));
  EXPECT_EQ(line,
            "a.jpg,2026-10-20T06:10:05Z,true,2.4904,0.2,0.15,0.013,1.3,59859.0,clear,0.25,0.125,66.3224,237.5,0.5,9.5,"
            "8.25,7,\n");
}

TEST(EstimateCsv, WhatIsMissingOrNullIsAnEmptyCell) {
  EXPECT_EQ(estimate_csv_line(R"({"image":"a.jpg","usable":false,"turbidity":null,"sun_seen":null,"circle":null,)"
                              R"("reason":"night"})",
                              std::nullopt),
            "a.jpg,,false,,,,,,,,,,,,,,,,night\n");
}

TEST(EstimateCsv, CommasQuotesAndLineBreaksStayInTheirCell) {
  const std::string image = "a \"b\", c\n.jpg";
  const auto rows = rows_of(estimate_csv_line(nlohmann::json{{"image", image}, {"reason", "x, y"}}.dump(), {}));
  ASSERT_EQ(rows.size(), 1u);
  ASSERT_EQ(rows[0].size(), 19u);
  EXPECT_EQ(rows[0].front(), image);
  EXPECT_EQ(rows[0].back(), "x, y");
  EXPECT_EQ(estimate_csv_line("b.jpg", std::nullopt, "one\ntwo, three"),
            "b.jpg,,false,,,,,,,,,,,,,,,,\"one two, three\"\n");
}

// Both ways of the command, on a frame that tells the air and a file that is no picture.
TEST(EstimateCsv, TheCommandWritesALineForEachPictureAsItsJsonSays) {
  const auto folder = test_folder("estimate-csv");
  std::filesystem::create_directories(folder);
  const auto frame = source_folder() / "fixtures/demo/sky/frame-000000.jpg";
  std::ofstream(folder / "broken.png") << "no picture";
  std::ofstream(folder / "list") << (folder / "broken.png").string() << "\n"
                                 << frame.string() << "\t2026-10-20T06:10:00Z\n";
  const auto arguments = fmt::format("--calibration {}/fixtures/demo/fixture.toml --list {}", source_folder().string(),
                                     (folder / "list").string());
  const auto table = ended(2, run_kasumi("estimate --csv " + arguments)),
             objects = run_kasumi("estimate --json " + arguments);
  EXPECT_THAT(table.err, HasSubstr("broken.png"));
  const auto rows = rows_of(table.out);
  ASSERT_EQ(rows.size(), 3u) << table.out;
  for (const auto& row : rows) ASSERT_EQ(row.size(), 19u);
  EXPECT_EQ(table.out.substr(0, table.out.find('\n') + 1), kHeader);
  EXPECT_EQ(rows[1][0], (folder / "broken.png").string());
  EXPECT_EQ(rows[1][2], "false");
  EXPECT_THAT(rows[1][18], HasSubstr("broken.png"));
  const auto json = parse_json(objects.out);
  EXPECT_EQ(rows[2][0], frame.string());
  EXPECT_EQ(rows[2][1], "2026-10-20T06:10:00Z");
  for (std::size_t column = 2; column < 9; ++column) EXPECT_EQ(rows[2][column], json[rows[0][column]].dump());
  EXPECT_EQ(rows[2][9], json["sky"]);
}

TEST(EstimateCsv, OnlyOneOfTheTwoForms) {
  EXPECT_THAT(ended(2, run_kasumi("estimate --csv --json --sun-from-image x.png")).err,
              testing::AllOf(HasSubstr("--csv"), HasSubstr("--json")));
  EXPECT_THAT(ended(2, run_kasumi("estimate --csv --haze x.png")).err, HasSubstr("--csv"));
}

}  // namespace
}  // namespace kasumi
