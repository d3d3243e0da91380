#include <vector>

#include <gtest/gtest.h>

#include "calib/pose/azimuth_fit.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

// A sun that stands somewhere, in pictures of a camera whose top points to azimuth `up`.
SunPair pair(double zenith_deg, double azimuth_deg, double up_deg, bool mirrored, double off_deg = 0.0) {
  const Direction stood = direction_from(from_degrees(zenith_deg), from_degrees(azimuth_deg));
  const Direction seen = direction_from(from_degrees(zenith_deg + off_deg), from_degrees(azimuth_deg - up_deg));
  return {mirrored ? mirrored_in_picture(seen) : seen, stood};
}

double off_deg(const AzimuthFit& turn, double up_deg) {
  return std::abs(std::remainder(to_degrees(turn.azimuth_up) - up_deg, 360.0));
}

TEST(AzimuthFit, OneSunTellsTheTurnButNoMirror) {
  for (const double up : {0.0, 75.0, 190.0, 359.0}) {
    const std::vector one{pair(50.0, 120.0, up, false)};
    const auto turn = must(fit_azimuth(one));
    EXPECT_LT(off_deg(*turn, up), 1e-6);
    EXPECT_FALSE(turn->mirror_known);
    EXPECT_EQ(turn->suns, 1);
  }
}

TEST(AzimuthFit, TwoSunsTellThatPicturesAreMirrored) {
  for (const bool mirrored : {false, true})
    for (const double up : {10.0, 200.0}) {
      const std::vector two{pair(50.0, 120.0, up, mirrored), pair(40.0, 170.0, up, mirrored)};
      const auto turn = must(fit_azimuth(two));
      EXPECT_EQ(turn->mirrored, mirrored);
      EXPECT_TRUE(turn->mirror_known);
      EXPECT_LT(off_deg(*turn, up), 1e-6);
    }
}

TEST(AzimuthFit, FalseSunsAreLeftOut) {
  std::vector<SunPair> suns;
  for (int k = 0; k < 6; ++k) suns.push_back(pair(60.0 - 4.0 * k, 100.0 + 20.0 * k, 33.0, true, k % 2 ? 0.8 : -0.8));
  suns.push_back(pair(30.0, 100.0, 180.0, false));
  suns.push_back(pair(70.0, 10.0, 250.0, false));
  const auto turn = must(fit_azimuth(suns));
  EXPECT_EQ(turn->suns, 6);
  EXPECT_TRUE(turn->mirrored);
  EXPECT_LT(off_deg(*turn, 33.0), 1.0);
  EXPECT_GT(turn->sigma.value, 0.0);
}

TEST(AzimuthFit, NoTwoThatAgreeTellNothing) {
  EXPECT_FALSE(fit_azimuth({}));
  const std::vector two{pair(50.0, 120.0, 10.0, false), pair(20.0, 200.0, 100.0, false)};
  EXPECT_FALSE(fit_azimuth(two));
}

}  // namespace
}  // namespace kasumi
