#include <cmath>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "pipeline/lab/photographs/camera_memory.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

SizedCircle picture(double x, double y, double radius, double confidence, int width = 480) {
  return {width, 480, FoundCircle{{{x, y}, radius, 0.5}, confidence, {}, 1.0, {}}};
}

std::map<std::filesystem::path, SizedCircle> named(const std::vector<SizedCircle>& circles) {
  std::map<std::filesystem::path, SizedCircle> pictures;
  for (const auto& circle : circles) pictures.emplace(fmt::format("{:02}.jpg", pictures.size()), circle);
  return pictures;
}

TEST(CameraMemory, SeveralPicturesMakeACameraAndOneDoesNot) {
  CameraMemory memory;
  memory.learn_circles(named({picture(240, 241, 220, 0.9), picture(240.5, 241, 220, 0.8), picture(241, 240, 221, 0.9),
                              picture(330, 200, 150, 0.9, 640)}));
  const auto* camera = memory.camera_of(480, 480, {{240, 241}, 220});
  ASSERT_TRUE(camera);
  EXPECT_EQ(camera->pictures, 3);
  EXPECT_NEAR(camera->circle.circle.radius_px, 220.0, 1.0);
  EXPECT_FALSE(memory.camera_of(640, 480, {{330, 200}, 150}));
  EXPECT_TRUE(memory.knows(640, 480, {{330, 200}, 150}));
  // A picture that shows its rim badly gets the camera's circle; one of another size keeps its own.
  const auto badly = must(memory.circle_of(picture(250, 236, 232, 0.12)));
  EXPECT_NEAR(badly->circle.radius_px, 220.0, 1.0);
  EXPECT_NEAR(memory.circle_of(picture(330, 200, 150, 0.2, 640))->circle.radius_px, 150.0, 1e-9);
  ASSERT_TRUE(memory.found_in("03.jpg"));
  EXPECT_EQ(memory.found_in("03.jpg")->width, 640);
  EXPECT_FALSE(memory.found_in("other.jpg"));
}

TEST(CameraMemory, TonesOfACameraAreJoinedAndAnotherCamerasAreNot) {
  CameraMemory memory;
  memory.learn_circles(named({picture(240, 241, 220, 0.9), picture(240, 241, 220, 0.9), picture(240, 240, 160, 0.9),
                              picture(240, 240, 160, 0.9)}));
  ASSERT_EQ(memory.cameras().size(), 2u);
  std::vector<CameraSight> sights;
  for (const char* file : {"00.jpg", "01.jpg", "a.jpg", "b.jpg"})
    sights.push_back({file, picture(240, 241, 220, 0.9), ToneSight{1.4, 0.15}, std::nullopt});
  memory.learn(sights);
  const auto* taught = memory.camera_of(480, 480, {{240, 241}, 220});
  const auto* other = memory.camera_of(480, 480, {{240, 240}, 160});
  ASSERT_TRUE(taught && other);
  EXPECT_GT(std::exp(taught->belief.log_exponent), 1.35);
  EXPECT_LT(taught->belief.sigma_log_exponent, 0.15);
  EXPECT_EQ(taught->tones, 4);
  // What a picture told is no part of what it is asked under; what the others told is.
  const auto beside = CameraMemory::belief_beside(*taught, "a.jpg");
  EXPECT_GT(beside.sigma_log_exponent, taught->belief.sigma_log_exponent);
  EXPECT_LT(std::exp(beside.log_exponent), std::exp(taught->belief.log_exponent));
  EXPECT_GT(std::exp(beside.log_exponent), 1.3);
  EXPECT_EQ(other->tones, 0);
  EXPECT_EQ(other->belief.sigma_log_exponent, CameraBelief{}.sigma_log_exponent);
}

TEST(CameraMemory, IsWrittenAndReadAgain) {
  const auto file = test_folder("camera-memory") / "memory.toml";
  std::filesystem::create_directories(file.parent_path());
  std::filesystem::remove(file);
  auto memory = CameraMemory::read(file);  // not there yet: empty
  ASSERT_TRUE(memory) << memory.error().message;
  auto with_horizon = picture(240, 241, 220, 0.9);
  with_horizon.found->horizon = ImageCircle{{241, 242}, 205.0, 0.4};
  memory->learn_circles(named({with_horizon, with_horizon}));
  const auto sun = [](double azimuth_deg) {
    const Direction stood = direction_from(from_degrees(50), from_degrees(azimuth_deg));
    return SunPair{mirrored_in_picture(direction_from(from_degrees(50), from_degrees(azimuth_deg - 30.0))), stood};
  };
  memory->learn({{"a.jpg", with_horizon, ToneSight{1.4, 0.15}, sun(100)},
                 {"b.jpg", with_horizon, ToneSight{1.3, 0.2}, sun(160)}});
  ASSERT_TRUE(memory->write(file));
  const auto again = must(CameraMemory::read(file));
  ASSERT_EQ(again->cameras().size(), 1u);
  const auto &was = memory->cameras()[0], &is = again->cameras()[0];
  EXPECT_EQ(is.circle.circle.radius_px, was.circle.circle.radius_px);
  ASSERT_TRUE(is.circle.horizon);
  EXPECT_EQ(is.circle.horizon->radius_px, 205.0);
  EXPECT_NEAR(is.belief.log_exponent, was.belief.log_exponent, 1e-12);
  EXPECT_NEAR(is.belief.sigma_log_exponent, was.belief.sigma_log_exponent, 1e-12);
  ASSERT_TRUE(is.turn);
  EXPECT_TRUE(is.turn->mirrored);
  EXPECT_NEAR(to_degrees(is.turn->azimuth_up), 30.0, 1e-9);
  EXPECT_EQ(is.pictures, 2);
  EXPECT_EQ(is.tones, 2);
  ASSERT_EQ(is.suns.size(), 2u);
  EXPECT_LT(to_degrees(angle_between(is.suns[1].seen, was.suns[1].seen)), 1e-4);
}

TEST(CameraMemory, AFileThatIsNoneIsRefusedWithEveryWrongKey) {
  const auto file = test_folder("camera-memory-bad") / "memory.toml";
  std::filesystem::create_directories(file.parent_path());
  ASSERT_TRUE(write_text_file(file, "[[cameras]]\nwidth = 480\nheight = -1\ncircle_px = [1, 2]\nsize = 3\n"));
  const auto read = CameraMemory::read(file);
  ASSERT_FALSE(read);
  for (const char* key : {"height", "circle_px", "size", "pictures"}) EXPECT_THAT(read.error().message, HasSubstr(key));
}

}  // namespace
}  // namespace kasumi
