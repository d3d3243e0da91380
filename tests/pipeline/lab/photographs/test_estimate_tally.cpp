#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/lab/photographs/estimate_tally.hpp"

namespace kasumi {
namespace {

TEST(EstimateTally, OneThatTellsTheAirIsEnough) {
  EstimateTally tally;
  tally.useless("overcast");
  tally.useful();
  EXPECT_EQ(tally.exit_code(), 0);
  EXPECT_EQ(tally.told("picture"), "");
  tally.unread();
  EXPECT_EQ(tally.exit_code(), 2);
}

TEST(EstimateTally, WhyNothingIsKnownIsTheCommonestReasonFirst) {
  EstimateTally tally;
  tally.useless("night");
  tally.useless("overcast");
  tally.useless("overcast");
  EXPECT_EQ(tally.exit_code(), 1);
  EXPECT_EQ(tally.told("picture"), "none of 3 pictures determines the air: 2 x overcast; 1 x night");
}

TEST(EstimateTally, OneAloneNeedsNoCounting) {
  EstimateTally tally;
  tally.useless("overcast");
  EXPECT_EQ(tally.told("scan"), "the scan does not determine the air: overcast");
}

TEST(EstimateTally, AnEmptyListIsNoSuccess) {
  EXPECT_EQ(EstimateTally().exit_code(), 1);
  EXPECT_THAT(EstimateTally().told("picture"), testing::HasSubstr("standard input is empty"));
}

}  // namespace
}  // namespace kasumi
