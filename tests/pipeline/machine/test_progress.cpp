#include <gtest/gtest.h>

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

}  // namespace
}  // namespace kasumi
