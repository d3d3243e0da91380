// What several pictures of one camera tell together. The world is the generator's: the program is tried, not the sky.
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/utc_text.hpp"
#include "estimator/sky/sun.hpp"
#include "pipeline/lab/photographs/learn_cameras.hpp"
#include "pipeline/site/files/picture_sink.hpp"
#include "tests/pipeline/recorded.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

const Site kSite{"", 34.7, 135.8, 100.0};

// A morning's pictures of a camera whose top points north, with a tone curve of its own.
std::vector<EstimateInput> series(const std::string& name, bool mirrored, double tone_exponent) {
  const auto folder = test_folder(name);
  std::filesystem::create_directories(folder);
  std::vector<EstimateInput> pictures;
  for (const char* time : {"2026-05-05T00:00:00Z", "2026-05-05T02:00:00Z", "2026-05-05T05:00:00Z"}) {
    const auto utc = parse_utc(time);
    const auto sun = sun_position(*utc, kSite).direction;
    fixtures::FisheyeRecipe recipe;
    recipe.turbidity = 2.5;
    recipe.world = fixtures::World::physical;
    recipe.sun_zenith = zenith_angle(sun);
    recipe.sun_azimuth = azimuth_angle(sun);
    auto pixels = fixtures::sky_picture(recipe).pixels;
    for (auto& pixel : pixels.elements())
      for (int c = 0; c < 3; ++c)
        pixel[c] = static_cast<std::uint8_t>(
            std::lround(255.0 * Response::srgb()
                                    .to_encoded(glm::dvec3(std::pow(
                                        Response::srgb().to_light(glm::dvec3(pixel[c] / 255.0)).x, tone_exponent)))
                                    .x));
    if (mirrored)
      for (int y = 0; y < pixels.height(); ++y) std::reverse(pixels.row(y), pixels.row(y) + pixels.width());
    const auto file = folder / fmt::format("{}.png", pictures.size());
    EXPECT_TRUE(write_png(file, pixels));
    pictures.push_back({file, utc, {}, 0});
  }
  return pictures;
}

PhotographSetup strange() {
  PhotographSetup options;
  options.site = kSite;
  options.unknown_camera = true;
  options.estimate.sky.every_model = true;
  return options;
}

TEST(LearnCameras, MirroredPicturesAreNoticedAndTurnedOver) {
  for (const bool mirrored : {false, true}) {
    const auto pictures = series(fmt::format("learn-{}", mirrored), mirrored, 1.0);
    const auto memory = learn_cameras(pictures, {strange()}, {}, false, 1);
    ASSERT_EQ(memory->cameras().size(), 1u);
    ASSERT_TRUE(memory->cameras()[0].turn);
    EXPECT_EQ(memory->cameras()[0].turn->mirrored, mirrored);
    EXPECT_TRUE(memory->cameras()[0].turn->mirror_known);
    EXPECT_LT(std::abs(std::remainder(to_degrees(memory->cameras()[0].turn->azimuth_up), 360.0)), 1.5);
    auto options = strange();
    options.memory = memory;
    PhotographEstimator photographs(options);
    for (const auto& picture : pictures) {
      const auto report = photographs.estimate_from(picture.file, picture.utc).value();
      EXPECT_EQ(report.mirrored, mirrored);
      EXPECT_EQ(report.sun.orientation, Orientation::from_series);
      ASSERT_TRUE(report.sun.disagreement);
      EXPECT_LT(to_degrees(*report.sun.disagreement), 2.0);
    }
  }
}

TEST(LearnCameras, SeveralSkiesTellTheToneCurveBetterThanOne) {
  const auto pictures = series("learn-tone", false, 1.35);
  const auto memory = learn_cameras(pictures, {strange()}, {}, false, 2);
  ASSERT_EQ(memory->cameras().size(), 1u);
  const auto& belief = memory->cameras()[0].belief;
  std::printf("tone exponent 1.35: %.3f +- %.3f from %d\n", std::exp(belief.log_exponent),
              std::exp(belief.log_exponent) * belief.sigma_log_exponent, memory->cameras()[0].tones);
  EXPECT_EQ(memory->cameras()[0].tones, 3);
  EXPECT_LT(std::abs(belief.log_exponent - std::log(1.35)), 2.5 * belief.sigma_log_exponent);
  EXPECT_LT(belief.sigma_log_exponent, 0.2);
}

// As a programme does that asks for a picture an hour.
TEST(LearnCameras, CallsOfOnePictureEachTeachAsMuchAsOneOfAll) {
  const auto pictures = series("learn-one-by-one", true, 1.35);
  const auto at_once = learn_cameras(pictures, {strange()}, {}, true, 1);
  CameraMemory memory;
  const auto file = test_folder("learn-one-by-one-memory") / "memory.toml";
  std::filesystem::create_directories(file.parent_path());
  for (const auto& picture : pictures) {
    ASSERT_TRUE(learn_cameras({picture}, {strange()}, memory, true, 1)->write(file));
    memory = CameraMemory::read(file).value();
  }
  ASSERT_EQ(memory.cameras().size(), 1u);
  const auto &one_by_one = memory.cameras()[0], &together = at_once->cameras()[0];
  EXPECT_EQ(one_by_one.pictures, 3);
  EXPECT_EQ(one_by_one.tones, 3);
  ASSERT_TRUE(one_by_one.turn && together.turn);
  EXPECT_TRUE(one_by_one.turn->mirrored && one_by_one.turn->mirror_known);
  EXPECT_EQ(one_by_one.turn->suns, together.turn->suns);
  EXPECT_LT(std::abs(std::remainder(to_degrees(one_by_one.turn->azimuth_up - together.turn->azimuth_up), 360.0)), 0.5);
  EXPECT_NEAR(one_by_one.belief.log_exponent, together.belief.log_exponent, together.belief.sigma_log_exponent);
  // A picture by itself, and none of it later, needs no memory.
  EXPECT_TRUE(learn_cameras({pictures[0]}, {strange()}, {}, false, 1)->cameras().empty());
}

TEST(LearnCameras, WhatCannotBeReadIsPassedOver) {
  const std::vector<EstimateInput> pictures{{"/nowhere/one.png", {}, {}, 0}, {"/nowhere/two.png", {}, {}, 0}};
  EXPECT_TRUE(learn_cameras(pictures, {strange()}, {}, false, 2)->cameras().empty());
}

}  // namespace
}  // namespace kasumi
