// Opening hours: parsing, local time, and what the screen does (design: faults, row 26).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/pipeline/kiosk/appliance/rig.hpp"

namespace kasumi {
namespace {

using namespace std::chrono;
using testing::HasSubstr;

OpeningHours every_day(const std::string& hours, const std::string& zone = {}) {
  OpeningHours opening;
  opening.time_zone = zone;
  opening.week.fill(parse_hours(hours).value());
  return opening;
}

// The first and the last minute of [from, from + length) it is open, and how many there are.
struct OpenMinutes {
  Utc first, last;
  int count = 0;
};
OpenMinutes open_minutes(const OpeningHours& opening, Utc from, hours length = 24h) {
  OpenMinutes found;
  for (auto at = from; at < from + length; at += 1min) {
    if (!opening.is_open(at)) continue;
    if (found.count++ == 0) found.first = at;
    found.last = at;
  }
  return found;
}

constexpr auto kSunday = sys_days{June / 21 / 2026};

TEST(OpeningHours, WithoutAnyItIsAlwaysOpen) {
  EXPECT_EQ(open_minutes({}, kSunday, 24h * 7).count, 7 * 24 * 60);
  EXPECT_TRUE(OpeningHours{}.is_always_open());
  EXPECT_FALSE(every_day("00:00-23:59").is_always_open());
}

TEST(OpeningHours, FromTheFirstMinuteToTheLast) {
  const auto open = open_minutes(every_day("09:00-17:30"), kSunday);
  EXPECT_EQ(open.first, kSunday + 9h);
  EXPECT_EQ(open.last, kSunday + 17h + 29min);
  EXPECT_EQ(open.count, 8 * 60 + 30);
  EXPECT_EQ(open_minutes(every_day("09:00-12:00, 13:30-17:30"), kSunday).count, 7 * 60);
  EXPECT_EQ(open_minutes(every_day("closed"), kSunday).count, 0);
}

TEST(OpeningHours, AnEveningMayLastPastMidnight) {
  auto opening = every_day("closed");
  opening.week[0] = parse_hours("18:00-01:30").value();
  const auto open = open_minutes(opening, kSunday, 48h);
  EXPECT_EQ(open.first, kSunday + 18h);
  EXPECT_EQ(open.last, kSunday + 25h + 29min);
  EXPECT_EQ(open.count, 7 * 60 + 30);
}

TEST(OpeningHours, ExceptionsGoBeforeWeekdaysAndLaterOnesBeforeEarlier) {
  auto opening = every_day("09:00-17:00");
  opening.exceptions =
      parse_exceptions("2026-06-20..2026-06-22 closed; 2026-06-21 10:00-12:00\n2027-01-01 closed\n").value();
  EXPECT_EQ(open_minutes(opening, kSunday - days(2)).count, 8 * 60);
  EXPECT_EQ(open_minutes(opening, kSunday - days(1)).count, 0);
  EXPECT_EQ(open_minutes(opening, kSunday).count, 2 * 60);
  EXPECT_EQ(open_minutes(opening, kSunday + days(1)).count, 0);
  EXPECT_EQ(open_minutes(opening, kSunday + days(2)).count, 8 * 60);
}

TEST(OpeningHours, NonsenseIsRejected) {
  for (const char* text :
       {"", "9:00-17:00", "09:00", "09:00-25:00", "09:00-17:60", "09:00-09:00", "09:00-17:00,", "open", "09:00-24:01",
        "24:00-09:00", "09.00-17.00", "-", "09:00-17:00-18:00", "+9:00-17:00"})
    EXPECT_FALSE(parse_hours(text)) << text;
  for (const char* text :
       {"closed", "2026-02-30 closed", "2026-12-24", "24.12.2026 closed", "2026-12-24...2026-12-26 closed",
        "2026-12-26..2026-12-24 closed", "2026-12-24 09:00", "2026-13-01 closed", ".. closed"})
    EXPECT_FALSE(parse_exceptions(text)) << text;
  EXPECT_TRUE(parse_exceptions(" ;\n; "));
}

class LocalHours : public testing::Test {
 protected:
  void SetUp() override {
    if (!is_time_zone("Europe/Zurich")) GTEST_SKIP() << "this machine knows no time zones (package tzdata)";
  }
};

// Central Europe: an hour before UTC in winter, two in summer; the clock changes at 01:00 UTC on the last Sundays of
// March and October.
TEST_F(LocalHours, TheWallClockChangesInSpringAndAutumn) {
  const auto opening = every_day("09:00-17:00", "Europe/Zurich");
  const auto opens = [&](sys_days day) { return open_minutes(opening, day).first - day; };
  EXPECT_EQ(opens(March / 28 / 2026), 8h);
  EXPECT_EQ(opens(March / 29 / 2026), 7h);
  EXPECT_EQ(opens(October / 24 / 2026), 7h);
  EXPECT_EQ(opens(October / 25 / 2026), 8h);
  EXPECT_EQ(open_minutes(opening, sys_days(January / 1 / 2026), 24h * 365).count, 365 * 8 * 60)
      << "the same length every day";
}

TEST_F(LocalHours, ASkippedHourIsNotOpenAndARepeatedHourCountsTwice) {
  const auto opening = every_day("02:15-02:45", "Europe/Zurich");
  const auto spring = sys_days(March / 29 / 2026), autumn = sys_days(October / 25 / 2026);
  EXPECT_EQ(open_minutes(opening, spring, 12h).count, 0);
  const auto twice = open_minutes(opening, autumn, 12h);
  EXPECT_EQ(twice.first, autumn + 15min);
  EXPECT_EQ(twice.last, autumn + 1h + 44min);
  EXPECT_EQ(twice.count, 60);
}

TEST_F(LocalHours, DaysFollowLocalTime) {
  auto opening = every_day("closed", "Asia/Tokyo");
  opening.week[1] = kAllDay;  // Monday, which begins there on Sunday at 15:00 UTC
  const auto open = open_minutes(opening, kSunday, 48h);
  EXPECT_EQ(open.first, kSunday + 15h);
  EXPECT_EQ(open.count, 24 * 60);
}

TEST_F(LocalHours, UnknownTimeZonesAreRejected) {
  for (const char* name : {"Europe/Atlantis", "../../../etc/passwd", "/etc/localtime", ""})
    EXPECT_FALSE(is_time_zone(name)) << name;
}

// A kiosk with hours; it starts at noon in Japan, on a Sunday.
RigOptions with_hours(const std::string& name, const std::string& opening) {
  return {.name = name, .more_config = "\n[opening]\n" + opening + "\n"};
}

TEST_F(LocalHours, Row26OutsideTheHoursTheScreenIsOffAndThatIsNoFault) {
  auto options = with_hours("row26", "time_zone = \"Asia/Tokyo\"\nevery_day = \"11:00-12:01, 12:03-12:30\"");
  options.utc = kSunday + 3h + 50s;
  const auto rig = running(options);
  const auto& display = rig->devices.display;
  const auto& status = rig->appliance->render().status();
  rig->advance(5s);
  EXPECT_EQ(rig->shown(), Shown::live) << "a second before";
  const auto closed = rig->advance_until([&] { return display.off; }, 3s);
  ASSERT_TRUE(closed);
  EXPECT_LE(*closed, 1500ms + 400ms) << "with the fade";
  const auto picture = rig->picture();
  EXPECT_TRUE(std::ranges::all_of(picture.elements(), [](const Rgb8& c) { return c.r + c.g + c.b == 0; }))
      << "black first";

  const auto alives = rig->notifier.alives;
  const auto pictures = status.pictures;
  rig->advance(100s, 100ms);
  EXPECT_TRUE(display.off);
  EXPECT_EQ(status.pictures, pictures) << "nothing is drawn while closed";
  EXPECT_GE(rig->notifier.alives, alives + 90) << "the service manager knows that all is well";
  EXPECT_EQ(rig->shown(), Shown::dark);
  EXPECT_EQ(name_of(rig->trouble()), "closed");
  EXPECT_TRUE(rig->status().scene_camera.health.up) << "the cameras keep running";

  const auto opened = rig->advance_until([&] { return !display.off; }, 30s);
  ASSERT_TRUE(opened);
  EXPECT_EQ(duration_cast<seconds>(rig->clock.utc() - kSunday), 3h + 3min) << "on time";
  // Pictures from before closing are never shown again.
  bool live = false;
  for (int i = 0; i < 100; ++i) {
    if (const auto age = rig->age_on_screen()) {
      ASSERT_LE(to_seconds(*age), 2.05);
    }
    live = live || rig->shown() == Shown::live;
    rig->advance(Rig::kTick);
  }
  EXPECT_TRUE(live);
  std::printf("%-52s on the stroke\n", "26 outside opening hours, then open");
}

TEST_F(LocalHours, Row26AScreenThatCannotBeTurnedOffShowsBlackOnceASecond) {
  auto options = with_hours("row26-black", "time_zone = \"Asia/Tokyo\"\nevery_day = \"closed\"");
  options.display.stays_on = true;
  Rig rig(options);
  rig.advance(3s);
  ASSERT_EQ(rig.shown(), Shown::dark);
  const auto& status = rig.appliance->render().status();
  const auto pictures = status.pictures, scene_frames = status.scene_frames;
  rig.advance(60s, 100ms);
  EXPECT_NEAR(static_cast<double>(status.pictures - pictures), 60.0, 3.0) << "a sign of life a second";
  EXPECT_EQ(status.scene_frames, scene_frames);
  const auto picture = rig.picture();
  EXPECT_TRUE(std::ranges::all_of(picture.elements(), [](const Rgb8& c) { return c.r + c.g + c.b == 0; }));
}

TEST_F(LocalHours, Row26AnUntrustedClockIgnoresOpeningHours) {
  auto options = with_hours("row26-clock", "time_zone = \"Asia/Tokyo\"\nevery_day = \"closed\"");
  options.clock_policy = "synchronized";
  Rig rig(options);
  rig.advance(20s);
  EXPECT_EQ(rig.shown(), Shown::degraded);
  rig.time.state = {.synchronized = true, .jumps = 1};
  EXPECT_TRUE(rig.advance_until([&] { return rig.devices.display.off; }, 3s));
}

// 02:58 in summer time; two minutes later it is 02:00 again.
TEST_F(LocalHours, Row26WhenSummerTimeEndsTheHourIsRepeated) {
  auto options = with_hours("row26-autumn", "time_zone = \"Europe/Zurich\"\nevery_day = \"02:00-02:59\"");
  options.utc = sys_days{October / 25 / 2026} + 58min;
  Rig rig(options);
  rig.advance(30s);
  EXPECT_NE(rig.shown(), Shown::dark);
  rig.advance(60s);
  EXPECT_EQ(rig.shown(), Shown::dark);
  EXPECT_TRUE(rig.devices.display.off);
  rig.advance(40s);
  EXPECT_NE(rig.shown(), Shown::dark);
  EXPECT_FALSE(rig.devices.display.off);
}

TEST_F(LocalHours, EveryProblemIsNamed) {
  const auto rig = running({.name = "opening-problems"});
  replace_in(rig->config, "[state]",
             "[opening]\ntime_zone = \"Europe/Atlantis\"\nevery_day = \"nine to five\"\nmonday = \"9-17\"\n"
             "exceptions = \"christmas closed\"\n[state]");
  rig->hang_up();
  rig->advance(100ms);
  const auto problems = testing::PrintToString(rig->status().reload->problems);
  for (const char* expected :
       {"opening.time_zone", "opening.every_day", "opening.monday", "opening.exceptions", "09:00-17:30"})
    EXPECT_THAT(problems, HasSubstr(expected));
}

}  // namespace
}  // namespace kasumi
