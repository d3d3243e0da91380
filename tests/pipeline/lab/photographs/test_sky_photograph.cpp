#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <glm/common.hpp>
#include <glm/matrix.hpp>

#include "base/files.hpp"
#include "calib/colour/colorimetry.hpp"
#include "capture/codec/encode.hpp"
#include "estimator/sky/preetham.hpp"
#include "pipeline/lab/photographs/sky_photograph.hpp"
#include "pipeline/site/files/picture_sink.hpp"
#include "tests/alpnach.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/recorded.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

std::filesystem::path generated(const fixtures::FisheyeRecipe& recipe, const std::string& name) {
  const auto file = test_folder("skies") / (name + ".png");
  std::filesystem::create_directories(file.parent_path());
  EXPECT_TRUE(write_png(file, fixtures::sky_picture(recipe).pixels));
  return file;
}

PhotographSetup photograph_setup(const fixtures::FisheyeRecipe& recipe) {
  PhotographSetup options;
  const double middle = 0.5 * (recipe.size - 1);
  options.circle = ImageCircle{{middle, middle}, 0.5 * recipe.size};
  options.sun = direction_from(recipe.sun_zenith, recipe.sun_azimuth);
  return options;
}

TEST(SkyPhotograph, AGeneratedSkyGivesItsTurbidity) {
  for (const double turbidity : {2.0, 4.0, 7.0}) {
    fixtures::FisheyeRecipe recipe;
    recipe.turbidity = turbidity;
    PhotographEstimator photographs(photograph_setup(recipe));
    const auto report = must(photographs.estimate_from(generated(recipe, "clear"), std::nullopt));
    ASSERT_TRUE(report->look.estimate.usable) << report->look.estimate.reason;
    EXPECT_NEAR(report->look.estimate.turbidity.value, turbidity, 0.1);
    ASSERT_TRUE(report->quality);
    // Angstrom's beta from Preetham's formula at 550 nm.
    EXPECT_NEAR(report->quality->aod_550, (0.04608 * turbidity - 0.04586) * std::pow(0.55, -1.3), 0.02);
  }
}

// In clear air; in thicker air it is clipped too widely in these pictures to be told from a bright sky.
TEST(SkyPhotograph, TheSunIsFoundInTheImageWhenAsked) {
  for (const auto world : {fixtures::World::preetham, fixtures::World::physical})
    for (const double zenith_deg : {20.0, 40.0, 50.0}) {
      fixtures::FisheyeRecipe recipe;
      recipe.world = world;
      recipe.turbidity = 2.0;
      recipe.sun_zenith = from_degrees(zenith_deg);
      recipe.sun_azimuth = from_degrees(140.0);
      auto options = photograph_setup(recipe);
      options.sun.reset();
      options.sun_from_image = true;
      PhotographEstimator photographs(options);
      const auto report = photographs.estimate_from(generated(recipe, "sun"), std::nullopt).value();
      ASSERT_TRUE(report.sun.direction) << report.look.estimate.reason;
      EXPECT_LT(to_degrees(angle_between(*report.sun.direction, direction_from(recipe.sun_zenith, recipe.sun_azimuth))),
                0.25);
      EXPECT_NE(report.sun.told.find("% sure"), std::string::npos) << report.sun.told;
    }
}

TEST(SkyPhotograph, WithoutACircleItIsFoundInThePicture) {
  fixtures::FisheyeRecipe recipe;
  auto options = photograph_setup(recipe);
  options.circle.reset();
  PhotographEstimator photographs(options);
  const auto report = photographs.estimate_from(generated(recipe, "circle"), std::nullopt).value();
  ASSERT_TRUE(report.circle);
  EXPECT_NEAR(report.circle->radius_px, 250.0, 4.0);
}

TEST(SkyPhotograph, ACoveredLensIsRefusedWithItsReason) {
  fixtures::FisheyeRecipe recipe;
  recipe.covered_lens = true;
  PhotographEstimator photographs(photograph_setup(recipe));
  const auto report = photographs.estimate_from(generated(recipe, "covered"), std::nullopt).value();
  EXPECT_FALSE(report.look.estimate.usable);
  EXPECT_EQ(report.look.estimate.sky, SkyCondition::covered_lens) << report.look.estimate.reason;
}

// By a calibrated camera, of a JPEG: what `light` says of a direction, with a sensor's noise.
struct FirstLookScene {
  PhotographSetup options;
  std::filesystem::path file;
  template <class Light>
  FirstLookScene(const std::string& name, const SunDirection& sun, const Light& light) {
    constexpr int kSide = 480;
    Camera camera;
    camera.name = "sky";
    camera.width = camera.height = kSide;
    const double middle = 0.5 * (kSide - 1), half = from_degrees(92.0).value;
    camera.lens = equidistant_lens({middle, middle}, 0.5 * kSide / half, {half});
    camera.to_world = camera_to_world(from_degrees(180.0), from_degrees(90.0), {0.0});
    Image<Rgb8> pixels(kSide, kSide);
    std::uint32_t state = 1;
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const auto view = camera.direction_at({x, y});
        if (!view || view->z <= 0.0) continue;
        const glm::dvec3 level = 255.0 * camera.response.to_encoded(light(*view));
        for (int c = 0; c < 3; ++c) {
          state = state * 1664525u + 1013904223u;
          const double noise = static_cast<int>(state >> 24) % 9 - 4;
          pixels.at(x, y)[c] = static_cast<std::uint8_t>(std::clamp(level[c] + noise, 0.0, 255.0));
        }
      }
    file = test_folder("skies") / (name + ".jpg");
    std::filesystem::create_directories(file.parent_path());
    EXPECT_TRUE(write_file(file, must(encode_jpeg(pixels, 90, ChromaSubsampling::s420)).value()));
    options.calibrated = camera;
    options.sun = sun;
    options.estimate.sky.every_model = true;
  }
  PhotographReport report(bool first_look) const {
    PhotographSetup setup = options;
    setup.first_look = first_look;
    return must(PhotographEstimator(setup).estimate_from(file, std::nullopt)).value();
  }
};

TEST(SkyPhotograph, AFirstLookSaysOfClosedSkiesWhatTheWholePictureDoes) {
  const SunDirection sun = direction_from(from_degrees(50.0), from_degrees(180.0));
  // Moon and Spencer's overcast sky, a third as bright at the horizon as above, a little bluish; fog.
  const auto overcast = [](const Direction& view) {
    return 0.45 * (1.0 + 2.0 * view.z) / 3.0 * glm::dvec3{0.97, 1.0, 1.04};
  };
  const auto covered = [](const Direction&) { return glm::dvec3{0.3, 0.3, 0.3}; };
  const FirstLookScene skies[] = {{"overcast", sun, overcast}, {"covered-jpeg", sun, covered}};
  const SkyCondition expected[] = {SkyCondition::overcast, SkyCondition::covered_lens};
  for (const int i : {0, 1}) {
    const PhotographReport first = skies[i].report(true), whole = skies[i].report(false);
    EXPECT_EQ(whole.look.estimate.sky, expected[i]) << whole.look.estimate.reason;
    EXPECT_EQ(first.look.estimate.sky, expected[i]) << first.look.estimate.reason;
    EXPECT_FALSE(first.look.estimate.usable);
    EXPECT_EQ(first.cover.sky, whole.cover.sky);
    EXPECT_EQ(first.cover.fraction.has_value(), whole.cover.fraction.has_value());
    EXPECT_NEAR(first.cover.fraction.value_or(1.0), whole.cover.fraction.value_or(1.0), 0.03);
    // It was by a first look indeed.
    ASSERT_TRUE(first.picture);
    EXPECT_EQ(first.picture->encoded.width(), 60);
    EXPECT_EQ(whole.picture->encoded.width(), 240);
  }
}

TEST(SkyPhotograph, AFirstLookLeavesClearSkiesAndShiningSunsToTheWholePicture) {
  const SunDirection sun = direction_from(from_degrees(50.0), from_degrees(180.0));
  const PreethamSky model({3.0}, sun);
  const glm::dmat3 to_light = glm::inverse(srgb_to_xyz());
  const auto clear = [&](const Direction& view) {
    return glm::clamp(0.1 * (to_light * model.relative_xyz(view)), glm::dvec3{0.0}, glm::dvec3{1.0});
  };
  // Through thin grey cloud, 3 deg across.
  const auto veiled = [&](const Direction& view) {
    const double disc = angle_between(view, sun) < from_degrees(1.5) ? 0.9 : 0.0;
    return glm::dvec3{std::min(1.0, 0.2 + 0.1 * view.z + disc)};
  };
  for (const FirstLookScene& sky :
       {FirstLookScene("clear-jpeg", sun, clear), FirstLookScene("veiled-sun", sun, veiled)}) {
    const PhotographReport first = sky.report(true), whole = sky.report(false);
    EXPECT_EQ(first.picture->encoded.width(), 240);
    EXPECT_EQ(first.look.estimate.turbidity.value, whole.look.estimate.turbidity.value);
    EXPECT_EQ(first.look.estimate.reason, whole.look.estimate.reason);
  }
}

// A real winter sky over Alpnach; details are in the data's README.
TEST(SkyPhotograph, TwoExposuresOfOneRealSkyAgree) {
  if (!alpnach::is_there()) GTEST_SKIP() << alpnach::file(0) << " is not here: real sky not tested";
  PhotographSetup options;
  options.field_of_view = from_degrees(alpnach::kFieldOfView_deg);
  options.circle = ImageCircle{alpnach::kCentre, alpnach::kRadius_px};
  options.linear_response = true;
  // Where exposures 1 to 7 show it. In these two it is clipped too widely to be found with certainty.
  options.sun = direction_from(from_degrees(62.8), from_degrees(48.0));
  PhotographEstimator photographs(options);
  std::vector<TurbidityEstimate> estimates;
  for (const int exposure : {8, 9}) {
    const auto report = must(photographs.estimate_from(alpnach::file(exposure), std::nullopt));
    ASSERT_TRUE(report->look.estimate.usable) << report->look.estimate.reason;
    estimates.push_back(report->look.estimate);
    std::printf("exposure %d: T %.3f +- %.3f\n", exposure, estimates.back().turbidity.value, estimates.back().sigma);
    EXPECT_GE(estimates.back().turbidity.value, 2.0);
    EXPECT_LE(estimates.back().turbidity.value, 2.6);
  }
  EXPECT_LE(std::abs(estimates[0].turbidity.value - estimates[1].turbidity.value),
            std::hypot(estimates[0].sigma, estimates[1].sigma) * 2.0);
}

}  // namespace
}  // namespace kasumi
