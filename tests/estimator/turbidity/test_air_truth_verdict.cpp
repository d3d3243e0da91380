// Whether what is no clear sky is refused, and what is one is used or refused for the true reason: two populations of
// skies before cameras of which the estimator knows nothing.
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "estimator/turbidity/turbidity.hpp"
#include "tests/alpnach.hpp"
#include "tests/estimator/turbidity/sky_population.hpp"
#include "tests/estimator/turbidity/strange_camera.hpp"
#include "tests/figures.hpp"
#include "tests/opencv_pictures.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using test::Population;

constexpr int kSide = 240;

TurbidityEstimate judge(const Image<Rgb8>& picture, const Camera& camera, const SunDirection& sun,
                        double altitude_m = test::kPopulationAltitude_m) {
  EstimateParameters options;
  options.sky.every_model = true;
  options.sky.altitude_m = altitude_m;
  return estimate_turbidity(*sky_picture(view_of(picture), camera), camera, sun, options);
}

// What a verdict says, without its numbers.
std::string gist_of(const TurbidityEstimate& estimate) {
  if (estimate.usable) return fmt::format("used as {}", name_of(estimate.sky));
  for (const char* const gist :
       {"overcast", "broken clouds", "clouds:", "washed out", "tone curve is not", "tone curve and vignetting",
        "vignetting:", "glare of", "colours", "no clear sky is nearer", "off by", "unexplained", "exposed"})
    if (estimate.reason.find(gist) != std::string::npos) return gist;
  return estimate.reason;
}

struct Tally {
  int pictures = 0, used = 0, used_as_clear = 0, called_cloudy = 0;
  int with_truth = 0, within_two_sigma = 0;
  double chi2 = 0.0;
  std::map<std::string, int> gists;

  void add(const test::PopulationSky& sky, const TurbidityEstimate& estimate) {
    ++pictures;
    ++gists[gist_of(estimate)];
    if (!estimate.usable) {
      if (estimate.sky == SkyCondition::overcast || estimate.sky == SkyCondition::partly_cloudy) ++called_cloudy;
      return;
    }
    ++used;
    if (estimate.sky == SkyCondition::clear) ++used_as_clear;
    if (!sky.aod_550 || !estimate.found) return;
    const double off = (estimate.found->aerosol.aod_550 - *sky.aod_550) / std::sqrt(estimate.found->covariance.aod_550);
    ++with_truth;
    chi2 += off * off;
    if (std::abs(off) < 2.0) ++within_two_sigma;
  }
  void print(const std::string& what) const {
    std::printf("%-46s %3d pictures: used %3d (as clear %3d)", what.c_str(), pictures, used, used_as_clear);
    if (with_truth > 0)
      std::printf(", AOD within 2 sigma %d of %d, chi2 %.1f each", within_two_sigma, with_truth, chi2 / with_truth);
    for (const auto& [gist, number] : gists) std::printf("; %s %d", gist.c_str(), number);
    std::printf("\n");
  }
};

class AirTruthVerdict : public testing::TestWithParam<Population> {
 protected:
  static int count() { return figure_cases("skies of each sort", std::vector<int>{8}, std::vector<int>{60}).front(); }
  // Printed for the population that nothing was developed on.
  static void row(const char* what, const std::string& found, const char* goal) {
    if (GetParam() == Population::held_out)
      figure_row("found-generated", {what, found, goal, "`test_air_truth_verdict`"});
  }
  static const char* name() { return GetParam() == Population::development ? "development" : "held out"; }
  static std::string measured_folder() { return (shared_data_folder() / "sky" / "cornell").string(); }
  static Tally judge_all(const std::vector<test::PopulationSky>& skies, bool any_camera, std::uint64_t first_seed) {
    const Camera believed = test::believed_camera(kSide);
    Tally tally;
    for (const test::PopulationSky& sky : skies) {
      const std::uint64_t seed = first_seed++;
      const auto camera = any_camera ? test::any_camera(GetParam(), seed) : test::plain_camera(seed);
      tally.add(sky, judge(test::photograph(sky, camera, kSide), believed, sky.sun));
    }
    return tally;
  }
};

TEST_P(AirTruthVerdict, ClosedCoversAreRefused) {
  const Tally tally = judge_all(test::overcast_skies(GetParam(), count()), true, 1);
  tally.print(fmt::format("overcast, any camera, {}", name()));
  row("overcast pictures accepted", fmt::format("{} of {}", tally.used, tally.pictures), "2 %");
  EXPECT_LE(tally.used, 0.02 * tally.pictures);
}

// Gaps between clouds may be used where the camera is known, but the sky is not called clear.
TEST_P(AirTruthVerdict, BrokenCloudsAreNotCalledClear) {
  const auto clear = test::cloudless_skies(GetParam(), count(), "");
  const auto skies = test::broken_skies(GetParam(), count(), clear);
  Tally all;
  for (const bool any_camera : {false, true}) {
    const Tally tally = judge_all(skies, any_camera, 500);
    tally.print(fmt::format("broken clouds, {}, {}", any_camera ? "any camera" : "sRGB", name()));
    row(any_camera ? "broken clouds called clear, any camera" : "broken clouds called clear, sRGB",
        fmt::format("{} of {}", tally.used_as_clear, tally.pictures), "2 %");
    EXPECT_LE(tally.used_as_clear, 0.02 * tally.pictures);
    EXPECT_GE(tally.within_two_sigma, 0.85 * tally.with_truth);
    if (any_camera) {
      EXPECT_LE(tally.used, std::ceil(0.1 * tally.pictures));
    }
  }
}

TEST_P(AirTruthVerdict, CloudlessSkiesBeforeAKnownCameraAreUsed) {
  const Tally tally = judge_all(test::cloudless_skies(GetParam(), count(), measured_folder()), false, 1000);
  tally.print(fmt::format("cloudless, sRGB, {}", name()));
  row("cloudless, sRGB: accepted; of those of known truth, within 2 sigma",
      fmt::format("{} of {}; {} of {}", tally.used, tally.pictures, tally.within_two_sigma, tally.with_truth),
      ">= 90 %; >= 95 %");
  EXPECT_GE(tally.used, 0.9 * tally.pictures);
  EXPECT_EQ(tally.called_cloudy, 0);
}

TEST_P(AirTruthVerdict, CloudlessSkiesBeforeAnyCameraAreUsedOrRefusedForTheCamera) {
  const Tally tally = judge_all(test::cloudless_skies(GetParam(), count(), measured_folder()), true, 1500);
  tally.print(fmt::format("cloudless, any camera, {}", name()));
  row("cloudless, cameras of unknown tone curve and vignetting: accepted; within 2 sigma",
      fmt::format("{} of {}; {} of {}", tally.used, tally.pictures, tally.within_two_sigma, tally.with_truth),
      "else refused with the reason; >= 95 %");
  EXPECT_LE(tally.called_cloudy, 0.1 * tally.pictures);
  EXPECT_GE(tally.within_two_sigma, 0.7 * tally.with_truth);
}

INSTANTIATE_TEST_SUITE_P(Both, AirTruthVerdict, testing::Values(Population::development, Population::held_out));

// Alpnach's thirteen exposures: linear pictures; what stands above the horizon is not masked.
TEST(AirTruthVerdictReal, AlpnachIsUsedWhereItIsExposed) {
  if (!alpnach::is_there()) GTEST_SKIP() << "no shared data";
  const Camera camera = alpnach::camera();
  const SunDirection sun = *camera.direction_at(alpnach::kSun);
  int used = 0;
  for (int exposure = 0; exposure < alpnach::kExposures; ++exposure) {
    const TurbidityEstimate e = judge(read_rgb(alpnach::file(exposure)), camera, sun, 500.0);
    std::printf("exposure %2d: %s\n", exposure,
                e.usable ? fmt::format("T {:.2f} +- {:.2f}, AOD {:.3f} +- {:.3f}, {}, off by {:.1f} %",
                                       e.turbidity.value, e.sigma, e.found->aerosol.aod_550,
                                       std::sqrt(e.found->covariance.aod_550), name_of(e.sky), 100.0 * e.log_residual)
                               .c_str()
                         : e.reason.c_str());
    if (e.usable) {
      ++used;
    } else {
      EXPECT_NE(e.reason.find("exposed"), std::string::npos) << e.reason;
    }
  }
  EXPECT_GE(used, 3);
}

}  // namespace
}  // namespace kasumi
