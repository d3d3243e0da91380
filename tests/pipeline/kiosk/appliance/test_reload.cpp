// New content: prepared on the GPU before anybody uses it, then used by all loops, or by none.
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "pipeline/site/files/picture_sink.hpp"
#include "tests/pipeline/kiosk/appliance/faulty_gl.hpp"
#include "tests/pipeline/kiosk/appliance/reloading.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

void fold_the_lens(const Rig& rig) {
  replace_in(rig.config, "distortion = [-0.6,", "distortion = [-300.0,");
}

// A recording of its own as scene camera, so that a loop which adopts the content is seen to open it.
void name_another_camera(const Rig& rig) {
  const auto other = rig.folder / "other";
  std::filesystem::copy(bench_fixture(), other, std::filesystem::copy_options::recursive);
  auto text = read_text_file(rig.config).value();
  const auto at = text.rfind(fmt::format("fixture = \"{}\"", bench_fixture().string()));
  text.replace(at, text.find('\n', at) - at, "fixture = \"other\"");
  ASSERT_TRUE(write_text_file(rig.config, text));
}

TEST(Appliance, AnotherCameraIsOpenedInsteadOfTheOldOne) {
  const auto rig = running({.name = "reload-camera"});
  name_another_camera(*rig);
  rig->hang_up();
  rig->advance(100ms);
  EXPECT_TRUE(rig->recover("reload with another scene camera", 3s));
  EXPECT_EQ(rig->status().scene_camera.health.opened, 1u) << "of the new camera";
}

// Compiled with the first picture of the building.
constexpr const char* kShaderOfTheLayer = "#define HAZE_PER_FRAGMENT";

struct Refusal {
  const char* name;
  const char* expected;
  std::function<void(Rig&)> spoil;
  std::function<void(Rig&)> mend{};
};

class Reload : public testing::TestWithParam<Refusal> {};

TEST_P(Reload, Row31ContentThatOnlyGlRefusesIsUsedByNobody) {
  const auto& refusal = GetParam();
  bool little_memory = false;
  RigOptions options{.name = fmt::format("row31-{}", refusal.name)};
  options.probes.memory_left = [&] { return little_memory ? 1'000'000u : 8'000'000'000u; };
  const auto rig = running(std::move(options));
  const auto good = read_text_file(rig->config).value();
  const int opened = rig->devices.scene.opened;
  name_another_camera(*rig);
  if (refusal.spoil)
    refusal.spoil(*rig);
  else
    little_memory = true;

  EXPECT_THAT(testing::PrintToString(problems_of_reload(*rig)), HasSubstr(refusal.expected));
  rig->advance(2s);
  EXPECT_EQ(rig->shown(), Shown::live);
  EXPECT_EQ(rig->devices.scene.opened, opened) << "the scene's loop uses content that was refused";
  EXPECT_EQ(rig->devices.display.opened, 1) << "the display was lost over it";
  EXPECT_EQ(rig->notifier.reloads, 1);

  if (refusal.mend) refusal.mend(*rig);
  little_memory = false;
  ASSERT_TRUE(write_text_file(rig->config, good));
  EXPECT_THAT(problems_of_reload(*rig), testing::IsEmpty()) << "content that is good again";
}
INSTANTIATE_TEST_SUITE_P(
    Kinds, Reload,
    testing::Values(
        Refusal{"lens", "folds the picture", fold_the_lens},
        Refusal{"mask", "foreground mask of 640 x 360 pixels",
                [](Rig& rig) {
                  replace_in(rig.config, "[scene]\nwidth = 320\nheight = 180", "[scene]\nwidth = 640\nheight = 360");
                  ASSERT_TRUE(write_png(rig.folder / "scene-mask.png", Image<Rgb8>(640, 360, Rgb8{255, 255, 255})));
                  rig.devices.display.largest_texture = 512;
                },
                [](Rig& rig) {
                  rig.devices.display.largest_texture = 0;
                  std::filesystem::copy_file(bench_fixture() / "scene-mask.png", rig.folder / "scene-mask.png",
                                             std::filesystem::copy_options::overwrite_existing);
                }},
        Refusal{"shader", "does not compile", [](Rig&) { gl_faults.shaders_with = kShaderOfTheLayer; },
                [](Rig&) { gl_faults.shaders_with.clear(); }},
        Refusal{"memory-of-the-gpu", "GL_OUT_OF_MEMORY",
                [](Rig& rig) {
                  gl_faults.no_memory_at_width = 777;
                  ASSERT_TRUE(write_png(rig.folder / "still.png", Image<Rgb8>(777, 500, Rgb8{9, 9, 9})));
                },
                [](Rig&) { gl_faults.no_memory_at_width = 0; }},
        Refusal{"memory", "MB are left", {}}),
    [](const auto& kind) {
      std::string name = kind.param.name;
      std::erase(name, '-');
      return name;
    });

// The second is asked for while the first is being prepared, and ordered when the first is ready but waits for a picture to be
// shown with. Were it thrown away then, it would be made again in one piece, while nothing is drawn: with shaders that are
// refused by then. Whichever moment between two pictures that is.
TEST(Reloading, WhatIsReadyIsShownBeforeTheNextIsBegun) {
  const auto rig = running({.name = "reload-twice"});
  const auto live_until = [&](const std::function<bool()>& condition) {
    return rig->advance_until(
        [&] {
          EXPECT_EQ(rig->shown(), Shown::live);
          return condition();
        },
        20s);
  };
  for (auto moment = 0 * Rig::kTick; moment < kSceneInterval; moment += 2 * Rig::kTick) {
    rig->advance(moment);
    const auto began = [rig = rig.get(), before = rig->notifier.reloads] { return rig->notifier.reloads - before; };
    rig->hang_up();
    rig->advance(Rig::kTick);
    ASSERT_EQ(began(), 1);
    rig->hang_up();
    ASSERT_TRUE(live_until([&] { return began() == 2; }));
    gl_faults.shaders_with = kShaderOfTheLayer;
    const auto refused = live_until([&] { return !rig->status().reload->problems.empty(); });
    gl_faults.shaders_with.clear();
    ASSERT_TRUE(refused);
    EXPECT_THAT(rig->status().reload->problems.front(), HasSubstr("does not compile"));
    ASSERT_EQ(rig->devices.display.opened, 1) << "the first was made again, and could not be";
    rig->hang_up();
    ASSERT_TRUE(live_until([&] { return rig->status().reload->problems.empty(); }));
  }
}

TEST(Reloading, WithoutADisplayContentIsTriedUnseen) {
  const auto rig = running({.name = "reload-no-display"});
  rig->devices.display.unplugged = true;
  rig->advance(1s);
  const auto good = read_text_file(rig->config).value();
  fold_the_lens(*rig);
  const auto problems = [&] {
    rig->hang_up();
    rig->advance(200ms);
    return testing::PrintToString(rig->status().reload->problems);
  };
  EXPECT_THAT(problems(), HasSubstr("folds the picture"));
  ASSERT_TRUE(write_text_file(rig->config, good));
  EXPECT_EQ(problems(), "{}");
  rig->devices.display.unplugged = false;
  rig->devices.display.told = true;
  EXPECT_TRUE(rig->recover("reload without a display", 3s));
}

TEST(Reloading, ADisplayThatIsLostMeanwhileDoesNotEndIt) {
  const auto rig = running({.name = "reload-lost"});
  for (int moment = 0; moment < 8; ++moment) {
    rig->hang_up();
    rig->advance(moment * Rig::kTick);
    rig->devices.display.context_lost = true;
    rig->advance(400ms);
    EXPECT_TRUE(rig->recover(fmt::format("17 GL context lost {} ms into a reload", moment * 20), 2s));
    ASSERT_TRUE(rig->status().reload);
    EXPECT_TRUE(rig->status().reload->doing.empty());
    EXPECT_TRUE(rig->status().reload->problems.empty()) << rig->status().reload->problems.front();
  }
}

}  // namespace
}  // namespace kasumi
