#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "pipeline/machine/progress.hpp"

namespace kasumi {
namespace {

using std::chrono::seconds;

TEST(Progress, TellsHowManyHowFastAndTheTimeLeft) {
  EXPECT_EQ(progress_text("estimate", 12, 30, seconds(6)),
            "estimate [############..................] 12/30, 2.0/s, 0:09 left");
  EXPECT_EQ(progress_text("estimate", 10, 2010, seconds(100)),
            "estimate [..............................] 10/2010, 0.10/s, 5:33:20 left");
  EXPECT_EQ(progress_text("estimate", 30, 30, seconds(60)), "estimate [##############################] 30/30, 0.50/s");
}

TEST(Progress, WithoutATotalTellsHowManyAndHowFast) {
  EXPECT_EQ(progress_text("estimate", 12, std::nullopt, seconds(6)), "estimate 12, 2.0/s");
}

TEST(Progress, BeforeTheFirstStepTellsNoRate) {
  EXPECT_EQ(progress_text("replay", 0, 4, seconds(6)), "replay [..............................] 0/4");
  EXPECT_EQ(progress_text("replay", 0, 0, seconds(6)), "replay [##############################] 0/0");
}

// What a cluster's task leaves in its log.
TEST(Progress, IsALineNowAndThenInALogWhereThatIsAsked) {
  testing::internal::CaptureStderr();
  {
    Progress silent("silent", 2), spoken("shard 3/40", 2, std::chrono::seconds(0)),
        rare("rare", 2, std::chrono::hours(1));
    for (Progress* progress : {&silent, &spoken, &rare}) progress->advance("");
  }
  const auto text = testing::internal::GetCapturedStderr();
  EXPECT_THAT(text, testing::StartsWith("kasumi: shard 3/40 ["));
  EXPECT_THAT(text, testing::HasSubstr("1/2"));
  EXPECT_EQ(std::ranges::count(text, '\n'), 1);
}

}  // namespace
}  // namespace kasumi
