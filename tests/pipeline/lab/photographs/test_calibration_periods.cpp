#include <gmock/gmock.h>

#include "base/utc_text.hpp"
#include "pipeline/lab/photographs/calibration_periods.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

std::string file_at(const CalibrationPeriods& periods, const char* utc) {
  const auto period = periods.at(*parse_utc(utc));
  return period ? periods.file(*period) : "none";
}

std::string problem_of(const std::vector<std::string>& given) {
  const auto periods = CalibrationPeriods::read(given);
  return periods ? "" : periods.error().message;
}

TEST(CalibrationPeriods, EachTimeHasItsFile) {
  const auto periods = CalibrationPeriods::read(
      {"2019-05-01..2020-01-01T12:00:00Z=b=1.toml", "..2019-05-01=a.toml", "2020-01-01T12:00:00Z..=c.toml"});
  ASSERT_TRUE(periods) << periods.error().message;
  EXPECT_EQ(file_at(*periods, "1999-01-01T00:00:00Z"), "a.toml");
  EXPECT_EQ(file_at(*periods, "2019-04-30T23:59:59Z"), "a.toml");
  EXPECT_EQ(file_at(*periods, "2019-05-01T00:00:00Z"), "b=1.toml");
  EXPECT_EQ(file_at(*periods, "2020-01-01T11:59:59Z"), "b=1.toml");
  EXPECT_EQ(file_at(*periods, "2031-01-01T00:00:00Z"), "c.toml");
  const auto some = CalibrationPeriods::read({"2019-05-01..2019-06-01=a.toml"});
  EXPECT_EQ(file_at(*some, "2019-06-01T00:00:00Z"), "none");
}

TEST(CalibrationPeriods, GapsOverlapsAndOtherWordsAreRefused) {
  EXPECT_THAT(problem_of({"..2019-05-01=a.toml", "2019-05-02..=b.toml"}), HasSubstr("leave a gap"));
  EXPECT_THAT(problem_of({"..2019-05-03=a.toml", "2019-05-02..=b.toml"}), HasSubstr("overlap"));
  EXPECT_THAT(problem_of({"2019-05-01..=a.toml", "2019-05-01..=b.toml"}), HasSubstr("overlap"));
  for (const char* wrong : {"a.toml", "..", "..=", "2019-05-01..2019-05-01=a.toml", "2019-13-01..=a.toml",
                            "2019..=a.toml", "a=..2019-05-01"})
    EXPECT_THAT(problem_of({wrong}), HasSubstr("--camera " + std::string(wrong) + ": expected FROM..TO=FILE")) << wrong;
}

}  // namespace
}  // namespace kasumi
