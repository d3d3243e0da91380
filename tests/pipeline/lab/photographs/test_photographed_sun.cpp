// The sun of a photograph: what is given held against what is seen, and a camera that nobody has oriented.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "base/utc_text.hpp"
#include "pipeline/lab/photographs/sky_photograph.hpp"
#include "pipeline/site/files/picture_sink.hpp"
#include "tests/alpnach.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

// In clear air, whose sun is found with certainty: 40 deg from the zenith, at azimuth 140 of the picture's own.
fixtures::FisheyeRecipe clear_sky() {
  fixtures::FisheyeRecipe recipe;
  recipe.turbidity = 2.0;
  recipe.sun_zenith = from_degrees(40.0);
  recipe.sun_azimuth = from_degrees(140.0);
  return recipe;
}

// As if the same picture had been taken under a sun at these angles from zenith and north.
PhotographReport looked_at(const fixtures::FisheyeRecipe& recipe, double zenith_deg, double azimuth_deg,
                           std::optional<double> azimuth_up_deg) {
  const auto file = test_folder("skies") / "photographed-sun.png";
  std::filesystem::create_directories(file.parent_path());
  EXPECT_TRUE(write_png(file, fixtures::sky_picture(recipe).pixels));
  PhotographSetup options;
  const double middle = 0.5 * (recipe.size - 1);
  options.circle = ImageCircle{{middle, middle}, 0.5 * recipe.size};
  options.sun = direction_from(from_degrees(zenith_deg), from_degrees(azimuth_deg));
  if (azimuth_up_deg) options.azimuth_up = from_degrees(*azimuth_up_deg);
  auto report = PhotographEstimator(options).estimate_from(file, std::nullopt);
  if (!report) ADD_FAILURE() << report.error().message;
  return report.value_or(PhotographReport{});
}

TEST(PhotographedSun, TellsHowACameraWasTurnedThatNobodyOriented) {
  const auto report = looked_at(clear_sky(), 40.0, 200.0, std::nullopt);
  EXPECT_EQ(report.sun.orientation, Orientation::from_sun);
  EXPECT_NEAR(degrees_of_azimuth(report.sun.azimuth_up), 60.0, 1.0);
  EXPECT_THAT(report.sun.orientation_told, HasSubstr("0 was assumed, but the sun in the picture is"));
  EXPECT_THAT(report.sun.orientation_told, HasSubstr("which was followed"));
  EXPECT_NEAR(to_degrees(azimuth_angle(*report.sun.direction)), 200.0, 1e-6);
  ASSERT_TRUE(report.look.estimate.usable) << report.look.estimate.reason;
  EXPECT_NEAR(report.look.estimate.turbidity.value, 2.0, 0.1);
}

TEST(PhotographedSun, AgreesWithNorthUpIfThatIsHowItWasTaken) {
  const auto report = looked_at(clear_sky(), 40.0, 140.0, std::nullopt);
  EXPECT_EQ(report.sun.orientation, Orientation::assumed);
  EXPECT_THAT(report.sun.orientation_told, HasSubstr("0 was assumed, and the sun in the picture agrees within"));
  EXPECT_TRUE(report.sun.doubt.empty()) << report.sun.doubt;
}

TEST(PhotographedSun, IsNamedFirstWhereItContradictsTheOrientationGiven) {
  const auto report = looked_at(clear_sky(), 40.0, 200.0, 0.0);
  EXPECT_EQ(report.sun.orientation, Orientation::given);
  EXPECT_GT(to_degrees(report.sun.disagreement.value()), 30.0);
  EXPECT_THAT(report.sun.orientation_told, HasSubstr("deg from where time, place and orientation put it"));
  ASSERT_FALSE(report.look.estimate.usable);
  EXPECT_THAT(report.look.estimate.reason, StartsWith("rejected: the sun is seen"));
  EXPECT_THAT(report.look.estimate.reason, HasSubstr("--azimuth-up-deg"));
}

TEST(PhotographedSun, ThatStandsAtAnotherHeightDoubtsTimeAndPlaceToo) {
  const auto report = looked_at(clear_sky(), 65.0, 200.0, std::nullopt);
  EXPECT_EQ(report.sun.orientation, Orientation::assumed);
  EXPECT_THAT(report.sun.doubt, HasSubstr("check time, place and lens"));
}

TEST(PhotographedSun, ThatIsNotSeenLeavesTheOrientationAssumedAndSaysSo) {
  auto recipe = clear_sky();
  recipe.cloud_cover = 0.95;
  const auto report = looked_at(recipe, 40.0, 200.0, std::nullopt);
  if (report.sun.seen) GTEST_SKIP() << "the clouds of this world let the sun through";
  EXPECT_EQ(report.sun.orientation, Orientation::assumed);
  EXPECT_THAT(report.sun.orientation_told, HasSubstr("0 was assumed, and no sun is seen"));
  EXPECT_THAT(report.sun.told, HasSubstr("no sun is seen in the image"));
  ASSERT_FALSE(report.look.estimate.usable);
  EXPECT_THAT(report.look.estimate.reason, StartsWith("the picture's orientation is not known"));
}

TEST(PhotographedSun, SaysHowSureItIs) {
  const auto report = looked_at(clear_sky(), 40.0, 140.0, 0.0);
  ASSERT_TRUE(report.sun.seen);
  EXPECT_THAT(report.sun.told, HasSubstr("% sure"));
  EXPECT_THAT(report.sun.told, Not(HasSubstr("no sun is seen")));
}

// Real fisheyes that nobody has oriented, by time and place alone: what docs/commands.md shows. Where the sun is found
// its place tells the orientation; where it is clipped too widely the refusal says that this is what is missing.
TEST(PhotographedSun, OrientsARealSkyByTimeAndPlace) {
  if (!alpnach::is_there()) GTEST_SKIP() << alpnach::file(0) << " is not here: real sky not tested";
  PhotographSetup options;
  options.field_of_view = from_degrees(alpnach::kFieldOfView_deg);
  options.circle = ImageCircle{alpnach::kCentre, alpnach::kRadius_px};
  options.linear_response = true;
  options.site = Site{"", 46.94, 8.28, 440.0};
  options.utc = parse_utc("2018-01-29T11:09:20Z");
  int oriented = 0;
  for (int exposure = 0; exposure < alpnach::kExposures; ++exposure) {
    const auto report = PhotographEstimator(options).estimate_from(alpnach::file(exposure), std::nullopt).value();
    const auto& estimate = report.look.estimate;
    std::printf("exposure %d: %s, up %.1f deg; T %.2f +- %.2f; %s\n", exposure,
                std::string(name_of(report.sun.orientation)).c_str(), degrees_of_azimuth(report.sun.azimuth_up),
                estimate.turbidity.value, estimate.sigma, estimate.usable ? "" : estimate.reason.c_str());
    if (report.sun.orientation == Orientation::from_sun) {
      ++oriented;
      EXPECT_NEAR(degrees_of_azimuth(report.sun.azimuth_up), 123.9, 1.5) << exposure;
    } else if (!estimate.usable && estimate.sky != SkyCondition::covered_lens) {
      EXPECT_THAT(estimate.reason, StartsWith("the picture's orientation is not known")) << exposure;
    }
    if (estimate.usable) {
      EXPECT_NEAR(estimate.turbidity.value, 2.3, 0.6) << exposure;
    }
  }
  EXPECT_GE(oriented, 6);
}

}  // namespace
}  // namespace kasumi
