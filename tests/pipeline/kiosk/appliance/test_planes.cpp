// The camera's picture on one plane of the display's, the building on the one above: the same picture, without the GPU,
// and without a flash on the way there and back.
#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/picture_difference.hpp"
#include "tests/pipeline/kiosk/appliance/rig.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

const std::string& planes(const Rig& rig) {
  return rig.status().render.display.planes;
}

RigOptions lent(const std::string& name, bool has_planes = true) {
  RigOptions options{.name = name};
  options.display.planes = has_planes;
  options.no_leaves = true;
  return options;
}

std::unique_ptr<Rig> running_on_planes(RigOptions options) {
  auto rig = std::make_unique<Rig>(std::move(options));
  rig->devices.scene.spoil = lend();
  rig->advance(5s);
  EXPECT_EQ(rig->shown(), Shown::live);
  return rig;
}

TEST(Planes, ShowThePictureThatTheGpuWouldCompose) {
  const auto with = running_on_planes(lent("planes-with")), without = running_on_planes(lent("planes-without", false));
  EXPECT_EQ(planes(*with), "on");
  EXPECT_THAT(planes(*without), HasSubstr("has no planes of its own"));
  EXPECT_TRUE(with->status().render.building_drawn);
  const auto uploads = with->status().render.uploads;
  const int shown = with->devices.display.on_planes;
  for (int i = 0; i < 20; ++i) {
    with->advance(kSceneInterval);
    without->advance(kSceneInterval);
    ASSERT_EQ(frame_number(with->picture()), frame_number(without->picture()));
    const auto found = difference(with->picture(), without->picture());
    EXPECT_LE(found.largest, 2) << "picture " << i;
    EXPECT_GE(found.psnr_db, 45.0);
  }
  EXPECT_GE(with->devices.display.on_planes, shown + 20);
  EXPECT_LT(with->status().render.uploads, uploads + 10)
      << "the GPU sees the camera's picture only to draw the building";
  EXPECT_EQ(with->status().render.scene_frames, without->status().render.scene_frames);
}

// Six buildings take turns, each with noise of its own; few of them are drawn anew.
// Which of them cover the building, is to be seen in each picture alone.
TEST(Planes, FollowLeavesThatMayMove) {
  auto leafy = lent("planes-leaves");
  leafy.no_leaves = false;
  const auto rig = running_on_planes(leafy);
  ASSERT_EQ(planes(*rig), "on");
  const auto uploads = rig->status().render.uploads;
  const int shown = rig->devices.display.on_planes;
  for (int i = 0; i < 10; ++i) rig->advance(kSceneInterval);
  EXPECT_GE(rig->devices.display.on_planes, shown + 10);
  EXPECT_GE(rig->status().render.uploads, uploads + 10);
}

TEST(Planes, CarryTheCamerasNoise) {
  auto options = lent("planes-noise");
  options.more_config = "\n[scene.noise]\nfull_scale_electrons = 500\nread_electrons = 3\n";
  const auto rig = running_on_planes(options);
  ASSERT_EQ(planes(*rig), "on");
  const auto uploads = rig->status().render.uploads;
  constexpr int kPictures = 24;
  std::set<std::vector<std::uint8_t>> buildings;
  for (int i = 0; i < kPictures; ++i) {
    rig->advance(kSceneInterval);
    const auto picture = rig->picture();
    std::vector<std::uint8_t> below_the_number;  // nothing but the building changes there
    for (int y = 20; y < picture.height(); ++y)
      for (int x = 0; x < picture.width(); ++x) below_the_number.push_back(picture.at(x, y).g);
    buildings.insert(std::move(below_the_number));
  }
  EXPECT_GE(buildings.size(), 6u);
  EXPECT_LE(rig->status().render.uploads - uploads, kPictures * 3 / 4) << "each is drawn every two seconds";
}

TEST(Planes, GiveWayToWhateverLiesOverTheScene) {
  const auto rig = running_on_planes(lent("planes-still"));
  ASSERT_EQ(planes(*rig), "on");
  rig->devices.scene.unplugged = true;
  ASSERT_TRUE(rig->advance_until([&] { return rig->shows_still(); }, 10s));
  EXPECT_EQ(planes(*rig), "the still picture is shown");
  EXPECT_GT(rig->status().render.camera_buffers_dropped, 0u);
  rig->devices.scene.unplugged = false;
  ASSERT_TRUE(rig->advance_until([&] { return planes(*rig) == "on"; }, 15s)) << planes(*rig);
  EXPECT_EQ(rig->status().render.display.resets, 0u);
}

// While the camera pauses, the same picture is shown again, and the buffer stays with the display.
TEST(Planes, ShowTheSamePictureAgain) {
  const auto rig = running_on_planes(lent("planes-again"));
  rig->devices.scene.silent = true;
  rig->advance(200ms);
  const auto before = rig->picture();
  const int shown = rig->devices.display.on_planes;
  rig->advance(1200ms);
  EXPECT_EQ(planes(*rig), "on");
  EXPECT_GE(rig->devices.display.on_planes, shown + 1);
  EXPECT_TRUE(std::ranges::equal(rig->picture().elements(), before.elements()));
}

TEST(Planes, LeaveOutARefusedPicture) {
  const auto rig = running_on_planes(lent("planes-refused"));
  const auto pictures = rig->status().render.pictures;
  const auto before = rig->picture();
  const int composed = rig->devices.display.composed;
  rig->devices.display.refused_planes = 2;
  rig->advance(kSceneInterval);
  EXPECT_TRUE(std::ranges::equal(rig->picture().elements(), before.elements())) << "what is shown stays";
  ASSERT_TRUE(rig->advance_until([&] { return rig->devices.display.refused_planes == 0; }, 2s));
  rig->advance(2 * kSceneInterval);
  EXPECT_EQ(planes(*rig), "on");
  EXPECT_GT(rig->status().render.pictures, pictures);
  EXPECT_EQ(rig->devices.display.composed, composed) << "never the other way for one picture";
  EXPECT_EQ(rig->status().render.display.resets, 0u);
}

// A camera that runs short of buffers copies a picture.
TEST(Planes, LeaveOutAPictureThatWasCopied) {
  const auto rig = running_on_planes(lent("planes-short"));
  const int composed = rig->devices.display.composed;
  int copied = 0;
  rig->devices.scene.spoil = [&, in_a_buffer = lend()](Frame& frame) {
    if (frame.metadata.sequence % 5 == 0)
      ++copied;
    else
      in_a_buffer(frame);
  };
  rig->advance(4s);
  EXPECT_GE(copied, 3);
  EXPECT_EQ(rig->devices.display.composed, composed);
  EXPECT_EQ(planes(*rig), "on");
  EXPECT_EQ(rig->shown(), Shown::live);
}

TEST(Planes, AreGivenUpUntilTheContentIsReloaded) {
  const auto rig = running_on_planes(lent("planes-given-up"));
  rig->devices.display.refused_planes = 3;
  ASSERT_TRUE(rig->advance_until([&] { return planes(*rig) != "on"; }, 3s));
  EXPECT_THAT(planes(*rig), HasSubstr("No space left"));
  EXPECT_EQ(rig->shown(), Shown::live);
  const int shown = rig->devices.display.on_planes;
  rig->advance(2s);
  EXPECT_EQ(rig->devices.display.on_planes, shown);
  EXPECT_THAT(planes(*rig), HasSubstr("No space left"));
  rig->hang_up();
  EXPECT_TRUE(rig->advance_until([&] { return planes(*rig) == "on"; }, 20s)) << planes(*rig);
}

TEST(Planes, AreNotAskedForTwiceWhereThereAreNone) {
  const auto rig = running_on_planes(lent("planes-none", false));
  rig->devices.display.planes = true;
  rig->advance(1s);
  EXPECT_THAT(planes(*rig), HasSubstr("has no planes of its own"));
}

TEST(Planes, AreNotUsedForPicturesThatOnlyTheProcessorReads) {
  Rig rig(lent("planes-copied"));
  rig.advance(4s);
  EXPECT_THAT(planes(rig), HasSubstr("do not lie in buffers"));
  rig.devices.scene.spoil = lend();
  rig.advance(1s);
  EXPECT_EQ(planes(rig), "on");
}

TEST(Planes, CanBeTurnedOff) {
  auto options = lent("planes-off");
  const auto rig = [&] {
    auto made = std::make_unique<Rig>(options);
    replace_in(made->config, "kind = \"headless\"", "kind = \"headless\"\nplanes = \"off\"");
    return made;
  }();
  rig->devices.scene.spoil = lend();
  rig->advance(3s);
  EXPECT_EQ(planes(*rig), "on");
  rig->hang_up();
  EXPECT_TRUE(rig->advance_until([&] { return planes(*rig) == "turned off in the configuration"; }, 20s));
  const int shown = rig->devices.display.on_planes;
  rig->advance(1s);
  EXPECT_EQ(rig->devices.display.on_planes, shown);
}

TEST(Planes, SurviveALostDisplay) {
  const auto rig = running_on_planes(lent("planes-lost"));
  rig->devices.display.context_lost = true;
  rig->advance(3s);
  EXPECT_EQ(rig->status().render.display.resets, 1u);
  EXPECT_EQ(planes(*rig), "on");
}

}  // namespace
}  // namespace kasumi
