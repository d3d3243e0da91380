// What is believed of status.json, and what is not.
#include <gmock/gmock.h>

#include <cmath>

#include "tests/report/told.hpp"

namespace kasumi::report {
namespace {

TEST(ReportedStatus, AGoodStatusIsUnderstoodWhole) {
  const auto told = parse_status(kGoodStatus).value();
  EXPECT_EQ(told.shown, Shown::live);
  EXPECT_EQ(told.trouble, Trouble::none);
  EXPECT_TRUE(told.values.is("display.up") && told.values.is("building_drawn") && told.scene_camera.values.is("up") &&
              told.sky_camera.values.is("up"));
  EXPECT_EQ(told.scene_camera.values["bad_frames"], 3.0);
  EXPECT_EQ(told.scene_camera.values["reopened"], 4.0);
  EXPECT_EQ(told.scene_camera.values["mode.frames_per_second"], 25.0);
  EXPECT_EQ(told.values["turbidity"], 2.41);
  EXPECT_EQ(told.values["air.sigma_aod_550"], 0.01);
  EXPECT_EQ(told.values["air.age_s"], 12.5);
  EXPECT_EQ(told.values["visibility.visibility_m"], 32000.0);
  EXPECT_TRUE(told.values.is("clock_trusted"));
  EXPECT_EQ(told.values["latency_ms_last_minute.p95"], 80.4);
  EXPECT_EQ(told.values["heat.celsius"], 51.5);
  EXPECT_THAT(told.hung_loops, testing::IsEmpty()) << "a loop that has not begun does not hang";
  EXPECT_THAT(told.drifted, testing::IsEmpty());
  EXPECT_EQ(*told.utc - *told.since, std::chrono::hours(28));
}

TEST(ReportedStatus, WhatIsImpossibleIsNotBelieved) {
  for (const auto& [was, is] : {std::pair{"2.41", "-3"},
                                {"2.41", "1e308"},
                                {"2.41", "\"2.41\""},
                                {"2.41", "[2.41]"},
                                {"2.41", "null"},
                                {"2.41", "true"}}) {
    SCOPED_TRACE(is);
    const auto told = parse_status(changed(kGoodStatus, was, is)).value();
    EXPECT_EQ(told.values["turbidity"], std::nullopt);
    EXPECT_EQ(told.values["sigma"], 0.05) << "the rest is kept";
  }
  const auto told = parse_status(changed(kGoodStatus, "\"short\": 2", "\"short\": -1e300")).value();
  EXPECT_EQ(told.scene_camera.values["bad_frames"], 1.0);
}

TEST(ReportedStatus, WhateverAPartIsTheRestIsRead) {
  for (const auto* part :
       {"display", "scene_camera", "air", "content", "start", "check", "visibility", "loops", "heat"})
    for (const auto* value : {"null", "3", "\"x\"", "[1, 2]", "[[]]", "true", "{}"}) {
      SCOPED_TRACE(std::string(part) + ": " + value);
      // The later of two equal keys counts.
      const auto told = parse_status(changed(kGoodStatus, "\"pid\"", fmt::format("\"{}\": {}, \"pid\"", part, value)));
      ASSERT_TRUE(told);
      EXPECT_EQ(told->values["turbidity"], 2.41);
    }
}

TEST(ReportedStatus, WhatIsNoStatusIsRefusedInASentence) {
  for (const std::string& text :
       {std::string(), std::string("{"), std::string("[]"), std::string("null"), kGoodStatus.substr(0, 700),
        std::string("{\"shown\": \"\xff\xfe\"}"), std::string("{\"turbidity\": 1e999}")}) {
    const auto told = parse_status(text);
    ASSERT_FALSE(told) << text;
    EXPECT_FALSE(told.error().message.empty());
  }
}

TEST(ReportedStatus, TheDeepAndTheLargeAreRefusedUnread) {
  const std::string deep(kDeepestStatus + 1, '[');
  EXPECT_THAT(parse_status("{\"a\":" + deep).error().message, testing::HasSubstr("deep"));
  EXPECT_TRUE(parse_status("{\"reason\": \"" + std::string(100, '[') + "\\\"[[[\"}")) << "brackets in a text are text";
  EXPECT_THAT(parse_status(std::string(kMostStatusBytes + 1, ' ')).error().message, testing::HasSubstr("bytes"));
}

TEST(ReportedStatus, TextsAreCutAndPlain) {
  std::string umlauts;
  for (int i = 0; i < 500; ++i) umlauts += "ü";
  const auto told =
      parse_status("{\"reason\": \"x" + umlauts + "\", \"sky\": \"a\\u0000\\n\\u001b[31mb\\u202ec\\u2067\"}").value();
  EXPECT_LE(told.reason.size(), kMostTextBytes);
  EXPECT_EQ(told.reason.size() % 2, 1U) << "cut between characters, not within one";
  EXPECT_EQ(told.sky, "a   [31mbc");
}

TEST(ReportedStatus, ListsAreCut) {
  std::string list = "\"x\"";
  for (int i = 0; i < 1000; ++i) list += ",\"x\"";
  const auto told = parse_status(changed(kGoodStatus, "\"refused\": []", "\"refused\": [" + list + "]")).value();
  EXPECT_EQ(told.refused.size(), kMostListed);
}

}  // namespace
}  // namespace kasumi::report
