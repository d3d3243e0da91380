// What an archive comes to, and the table and page that it becomes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sqlite3.h>
#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/outside/json_text.hpp"
#include "pipeline/lab/archive/archive_figures.hpp"
#include "pipeline/lab/archive/archive_plots.hpp"
#include "pipeline/lab/archive/record_table.hpp"
#include "pipeline/lab/archive/summary_page.hpp"
#include "tests/pipeline/lab/archive/made_archive.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {
namespace {

using std::chrono::minutes;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::Pair;
using namespace std::chrono_literals;

nlohmann::json clear_record(const char* utc, double aod, double cloud) {
  return {{"utc", utc}, {"refused", nullptr}, {"aod_550", aod}, {"cloud_fraction", cloud}};
}

TEST(ArchiveFigures, DaysAndHoursAreWallTime) {
  ArchiveFigures figures(9h);
  figures.add(clear_record("2025-12-31T14:59:59Z", 0.1, 0.2));
  figures.add(clear_record("2025-12-31T15:00:00Z", 0.3, 0.4));
  ASSERT_EQ(figures.days().size(), 2u);
  EXPECT_EQ(figures.days().begin()->first, std::chrono::sys_days(2025y / 12 / 31));
  EXPECT_EQ(figures.at(11, 23).aods(), 1u);
  EXPECT_EQ(figures.at(0, 0).aods(), 1u);
  EXPECT_NEAR(*figures.month(0).cloud(), 0.4, 1e-12);
}

TEST(ArchiveFigures, ADaysAerosolIsTheMedianOfItsClearPictures) {
  ArchiveFigures figures(0h);
  for (const double aod : {0.30, 0.10, 0.20, 5.0, 0.15}) figures.add(clear_record("2025-06-01T10:00:00Z", aod, 0.0));
  auto refused = clear_record("2025-06-01T11:00:00Z", 9.0, 1.0);
  refused["refused"] = "overcast";
  figures.add(refused);
  const auto& day = figures.days().begin()->second;
  EXPECT_NEAR(day.aod()->median, 0.20, 1e-6);
  EXPECT_EQ(day.aods(), 5u);
  EXPECT_NEAR(*day.cloud(), 1.0 / 6.0, 1e-12);
  EXPECT_EQ(figures.usable(), 5u);
}

TEST(ArchiveFigures, ReasonsThatDifferInTheirNumbersAreOne) {
  ArchiveFigures figures(0h);
  for (const char* reason : {"night", "the sun is 1.5 deg off", "the sun is 23 deg off"})
    figures.add({{"utc", nullptr}, {"refused", reason}});
  EXPECT_THAT(figures.refusals(), ElementsAre(Pair("the sun is ... deg off", 2), Pair("night", 1)));
  EXPECT_EQ(figures.timeless(), 3u);
  EXPECT_TRUE(figures.days().empty());
}

class Summary : public testing::Test {
 protected:
  static constexpr std::size_t kDays = 40;
  void SetUp() override {
    for (std::size_t i = 1; i <= 144 * kDays; ++i) {
      figures.add(parse_json(made.record(i)));
      series.add(parse_json(made.record(i)));
    }
  }
  const MadeArchive made{144 * kDays};
  ArchiveFigures figures{minutes(0)};
  SeriesFigures series{minutes(0)};
};

std::size_t count_of(const std::string& text, std::string_view words) {
  std::size_t count = 0;
  for (auto at = text.find(words); at != std::string::npos; at = text.find(words, at + 1)) ++count;
  return count;
}

TEST_F(Summary, ThePageHoldsItsFiguresAndFetchesNothing) {
  const auto page = summary_page({figures, series, nullptr, made.archive()});
  EXPECT_THAT(page,
              AllOf(HasSubstr("5760 pictures, each exactly once, from 2025-01-01T00:00:00Z to 2025-02-09T23:50:00Z"),
                    HasSubstr("0123456789abcdef"), HasSubstr("could not be read"), Not(HasSubstr("<script")),
                    Not(HasSubstr("http")), Not(HasSubstr("url("))));
  EXPECT_EQ(count_of(page, "<svg"), 9u);
  EXPECT_EQ(count_of(page, "role=\"img\" aria-label="), 9u);
  const auto half = 100.0 * static_cast<double>(figures.refusals().front().second) / 5760.0;
  EXPECT_EQ(figures.refusals().front().first, "night");
  EXPECT_THAT(page, HasSubstr(fmt::format("{:.1f} %, night", half)));
}

TEST(ArchiveFigures, SunsAreCountedWhereTheAirIsKnown) {
  ArchiveFigures some(0h);
  const auto at = [&](double zenith_deg, double azimuth_deg, const char* refused) {
    nlohmann::json record{{"sun_zenith_deg", zenith_deg}, {"sun_azimuth_deg", azimuth_deg}, {"refused", nullptr}};
    if (refused) record["refused"] = refused;
    some.add(record);
  };
  at(45.0, 181.0, nullptr);
  at(41.0, 194.0, nullptr);
  at(45.0, 181.0, "overcast");
  at(0.0, -1.0, nullptr);
  EXPECT_EQ(some.suns(4, 12), 2u);
  EXPECT_EQ(some.suns(8, 23), 1u);
  EXPECT_THAT(plot_suns(some), HasSubstr("azimuth 180 to 195, height 40 to 50 degrees: 2 pictures"));
}

// Days that are overcast have no aerosol, and say so.
TEST_F(Summary, TheCalendarHasASquareForEachDay) {
  const auto calendar = plot_calendar(figures, ArchiveFigure::aod);
  EXPECT_EQ(count_of(calendar, "<title>2025-"), kDays);
  EXPECT_THAT(calendar, HasSubstr("<title>2025-01-02: not known</title>"));
  EXPECT_THAT(calendar, HasSubstr("<title>2025-01-01: 0."));
}

TEST_F(Summary, AnArchiveWithoutTimesHasNoPlotsOverTime) {
  ArchiveFigures timeless(0h);
  timeless.add({{"utc", nullptr}, {"refused", "a <b> reason"}});
  const auto page = summary_page({timeless, SeriesFigures(0h), nullptr, made.archive()});
  EXPECT_THAT(page, AllOf(HasSubstr("1 have no time"), HasSubstr("a &lt;b&gt; reason"), Not(HasSubstr("By season"))));
}

class Table : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
  }
  std::filesystem::path written(const char* name) const {
    const auto path = folder / name;
    const auto table = open_record_table(path);
    EXPECT_TRUE(table) << table.error().message;
    if (!table) return path;
    for (std::size_t i = 1; i <= 1000; ++i) {
      auto line = made.record(i);
      line.pop_back();
      EXPECT_TRUE((*table)->add(line, parse_json(line)));
    }
    EXPECT_TRUE((*table)->finish());
    return path;
  }
  const std::filesystem::path folder = test_folder("record-table");
  const MadeArchive made{1000};
};

// The first column of each row.
std::vector<std::string> asked(const std::filesystem::path& file, const std::string& sql, int column = 0) {
  sqlite3* database = nullptr;
  EXPECT_EQ(sqlite3_open_v2(file.c_str(), &database, SQLITE_OPEN_READONLY, nullptr), SQLITE_OK);
  sqlite3_stmt* statement = nullptr;
  EXPECT_EQ(sqlite3_prepare_v2(database, sql.c_str(), -1, &statement, nullptr), SQLITE_OK) << sqlite3_errmsg(database);
  std::vector<std::string> rows;
  while (sqlite3_step(statement) == SQLITE_ROW) {
    const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement, column));
    rows.emplace_back(text ? text : "NULL");
  }
  sqlite3_finalize(statement);
  sqlite3_close(database);
  return rows;
}

TEST_F(Table, SqliteHasARowForEachPictureAndIndices) {
  const auto file = written("all.sqlite");
  EXPECT_THAT(asked(file, "SELECT count(*) FROM pictures"), ElementsAre("1000"));
  EXPECT_THAT(asked(file, "SELECT image FROM pictures WHERE utc = '2025-01-01T12:00:00Z'"),
              ElementsAre("sky/000073.jpg"));
  EXPECT_THAT(asked(file, "SELECT typeof(aod_550) FROM pictures WHERE picture IN (1, 73) ORDER BY picture"),
              ElementsAre("null", "real"));
  EXPECT_THAT(asked(file, "SELECT refused FROM pictures WHERE picture = 997"), ElementsAre("could not be read"));
  for (const char* column : {"utc", "verdict"})
    EXPECT_THAT(asked(file, fmt::format("EXPLAIN QUERY PLAN SELECT * FROM pictures WHERE {} = 'x'", column), 3),
                ElementsAre(HasSubstr(fmt::format("USING INDEX pictures_by_{}", column))));
  EXPECT_THAT(asked(file, "PRAGMA integrity_check"), ElementsAre("ok"));
}

TEST_F(Table, TextHasALineForEachPicture) {
  EXPECT_EQ(read_text_file(written("all.jsonl")).value_or(""), made.records(1, 1000));
  const auto csv = read_text_file(written("all.csv")).value_or("");
  EXPECT_EQ(count_of(csv, "\n"), 1001u);
  EXPECT_THAT(csv, HasSubstr("\nsky/000073.jpg,2025-01-01T12:00:00Z,true,2.5,0.2,"));
}

TEST_F(Table, OtherNamesAreRefused) {
  const auto table = open_record_table(folder / "all.parquet");
  ASSERT_FALSE(table);
  EXPECT_THAT(table.error().message, AllOf(HasSubstr("all.parquet"), HasSubstr(".sqlite")));
}

}  // namespace
}  // namespace kasumi
