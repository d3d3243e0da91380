// Eras: when which is shown, and what is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/site/config/eras.hpp"

namespace kasumi {
namespace {

using namespace std::chrono;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

OpeningHours open_from(const std::string& hours) {
  OpeningHours opening;
  opening.week.fill(parse_hours(hours).value());
  return opening;
}

struct ReadEras {
  std::vector<Era> eras;
  std::string problems;  // empty: none
};
ReadEras read_era_keys(const std::string& text, const OpeningHours& opening = {}) {
  const auto root = ConfigTable::parse(text, "kasumi.toml").value();
  ReadEras found{read_eras(root, opening), {}};
  if (auto whole = root.finish(); !whole) found.problems = whole.error().message;
  return found;
}

std::string era(const std::string& name, const std::string& when) {
  return "[[era]]\nname = \"" + name + "\"\n" + when + "\n";
}

std::string shown(const ReadEras& read, Utc now, const std::string& zone = {}) {
  const auto index = era_at(read.eras, zone, now);
  return index ? read.eras.at(*index).name : "";
}

constexpr auto kMidsummer = sys_days{June / 21 / 2026};

TEST(Eras, OneForVisitorsAloneIsNeverShownByDate) {
  const auto read = read_era_keys(era("now", "") + era("ruin", "visitors_only = true") +
                                  era("new-year", "dates = \"01-01\"") + era("fire", "visitors_only = true"));
  EXPECT_EQ(read.problems, "");
  EXPECT_TRUE(read.eras[1].visitors_only);
  EXPECT_EQ(shown(read, sys_days{December / 31 / 2026} + 18h), "now");
  EXPECT_EQ(shown(read, sys_days{January / 1 / 2027} + 2h), "new-year");
  EXPECT_THAT(read_era_keys(era("now", "") + era("ruin", "visitors_only = true\nhours = \"09:00-12:00\"")).problems,
              testing::HasSubstr("visitors_only"));
  EXPECT_THAT(read_era_keys(era("ruin", "visitors_only = true")).problems, testing::HasSubstr("none is shown"));
}

TEST(Eras, SeasonsGoPastTheYearsEnd) {
  const auto two = read_era_keys(era("leaves", "dates = \"03-01..10-31\"") + era("snow", "dates = \"11-01..02-29\""));
  EXPECT_EQ(two.problems, "");
  EXPECT_EQ(shown(two, sys_days{March / 1 / 2026}), "leaves");
  EXPECT_EQ(shown(two, sys_days{March / 1 / 2026} - 1s), "snow");
  EXPECT_EQ(shown(two, sys_days{October / 31 / 2026} + 24h - 1s), "leaves");
  EXPECT_EQ(shown(two, sys_days{November / 1 / 2026}), "snow");
  EXPECT_EQ(shown(two, sys_days{January / 1 / 2027}), "snow");
  EXPECT_EQ(shown(two, sys_days{February / 29 / 2028} + 12h), "snow");
}

TEST(Eras, HoursGoPastMidnightAndBelongToTheDayTheyBeginOn) {
  const auto eras = read_era_keys(era("eve", "dates = \"12-31\"\nhours = \"18:00-02:00\"") + era("day", ""));
  EXPECT_EQ(eras.problems, "");
  EXPECT_EQ(shown(eras, sys_days{December / 31 / 2026} + 18h), "eve");
  EXPECT_EQ(shown(eras, sys_days{January / 1 / 2027} + 2h - 1s), "eve");
  EXPECT_EQ(shown(eras, sys_days{January / 1 / 2027} + 2h), "day");
  EXPECT_EQ(shown(eras, sys_days{December / 31 / 2026} + 1h), "day");
}

TEST(Eras, TheWallClockDecides) {
  if (!is_time_zone("Europe/Zurich")) GTEST_SKIP() << "this machine knows no time zones (package tzdata)";
  const auto eras =
      read_era_keys(era("morning", "hours = \"00:00-12:00\"") + era("afternoon", "hours = \"12:00-24:00\""));
  EXPECT_EQ(shown(eras, kMidsummer + 10h - 1s, "Europe/Zurich"), "morning");
  EXPECT_EQ(shown(eras, kMidsummer + 10h, "Europe/Zurich"), "afternoon");
  EXPECT_EQ(shown(eras, sys_days{December / 21 / 2026} + 11h - 1s, "Europe/Zurich"), "morning");
}

TEST(Eras, WhileClosedTheNextToComeIsReady) {
  const auto eras =
      read_era_keys(era("morning", "hours = \"09:00-12:00\"") + era("afternoon", "hours = \"12:00-17:00\""),
                    open_from("09:00-17:00"));
  EXPECT_EQ(eras.problems, "") << "nobody sees the night";
  EXPECT_EQ(shown(eras, kMidsummer + 17h), "morning");
  EXPECT_EQ(shown(eras, kMidsummer + 3h), "morning");
  EXPECT_EQ(shown(eras, kMidsummer + 12h), "afternoon");
}

TEST(Eras, WithoutAnyThereIsNone) {
  EXPECT_EQ(read_era_keys("").problems, "");
  EXPECT_FALSE(era_at({}, "", kMidsummer));
}

TEST(Eras, EveryOverlapAndGapIsNamedAtOnce) {
  const auto bad = read_era_keys(
      era("a", "dates = \"03-01..06-30\"") + era("b", "dates = \"06-01..10-31\"\nhours = \"08:00-12:00\""),
      open_from("09:00-17:00"));
  EXPECT_THAT(bad.problems, AllOf(HasSubstr("\"a\" and \"b\" are both shown on 06-01..06-30, 08:00-12:00"),
                                  HasSubstr("none is shown on 01-01..02-29, 09:00-17:00"),
                                  HasSubstr("none is shown on 07-01..10-31, 12:00-17:00"),
                                  HasSubstr("none is shown on 11-01..12-31, 09:00-17:00")));
  const auto leap = read_era_keys(era("a", "dates = \"03-01..12-31\"") + era("b", "dates = \"01-01..02-28\""));
  EXPECT_THAT(leap.problems, HasSubstr("none is shown on 02-29, 00:00-24:00"));
}

TEST(Eras, AGapOnAnExceptionalEveningIsOne) {
  auto opening = open_from("09:00-17:00");
  opening.exceptions = parse_exceptions("2026-08-01 09:00-22:00").value();
  const auto eras = read_era_keys(era("a", "hours = \"09:00-17:00\""), opening);
  EXPECT_THAT(eras.problems, HasSubstr("none is shown on 01-01..12-31, 17:00-22:00"));
  EXPECT_EQ(read_era_keys(era("a", "hours = \"09:00-17:00\"") + era("evening", ""), opening).problems, "");
}

TEST(Eras, NonsenseIsNamed) {
  const auto bad = read_era_keys(era("", "dates = \"spring\"") + era("x", "hours = \"nine\"") +
                                 era("x", "dates = \"02-30\"") + era("y", "") + era("z", "caption = \"z\""));
  EXPECT_THAT(bad.problems, AllOf(HasSubstr("a name"), HasSubstr("spring"), HasSubstr("03-01..05-31"),
                                  HasSubstr("nine"), HasSubstr("02-30"), HasSubstr("a name that no other era has"),
                                  HasSubstr("rest of the time already")));
  for (const char* text :
       {"", "3-1", "03-01..", "..03-01", "03-01...05-31", "13-01", "04-31", "2026-03-01", "03-01;04-01"})
    EXPECT_FALSE(parse_yearly(text)) << text;
  std::string many;
  for (int i = 0; i < 25; ++i) many += era(std::to_string(i), "dates = \"01-01\"");
  EXPECT_THAT(read_era_keys(many).problems, AllOf(HasSubstr("at most 24"), Not(HasSubstr("both"))));
}

TEST(Eras, WakesBeforeOpening) {
  const auto opening = open_from("09:00-09:01");
  EXPECT_FALSE(opening.is_awake(kMidsummer + 8h + 44min + 59s, 15min));
  EXPECT_TRUE(opening.is_awake(kMidsummer + 8h + 45min, 15min));
  EXPECT_TRUE(opening.is_awake(kMidsummer + 8h + 50min + 30s, 15min)) << "a minute's opening is not stepped over";
  EXPECT_TRUE(opening.is_awake(kMidsummer + 9h + 59s, 15min));
  EXPECT_FALSE(opening.is_awake(kMidsummer + 9h + 1min, 15min));
  EXPECT_FALSE(opening.is_awake(kMidsummer + 8h + 59min + 59s, 0min));
}

}  // namespace
}  // namespace kasumi
