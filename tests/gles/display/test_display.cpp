// Displays that need no hardware: what is shown, when it counts as shown, and how long the camera's buffer is held.
#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "gles/display/headless_display.hpp"
#include "gles/gl/gl.hpp"
#include "tests/environment.hpp"
#include "tests/gles/display/display_helpers.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

std::unique_ptr<HeadlessDisplay> headless(ManualClock& clock, int width = 8, int height = 6) {
  auto display = open_headless_display({.width = width, .height = height}, clock);
  EXPECT_TRUE(display.has_value()) << (display ? "" : display.error().message);
  return display ? std::move(*display) : nullptr;
}

void fill(const DrawTarget& target, Rgb8 colour) {
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
  glClearColor(static_cast<float>(colour.r) / 255.0f, static_cast<float>(colour.g) / 255.0f,
               static_cast<float>(colour.b) / 255.0f, 1.0f);
  glClear(GL_COLOR_BUFFER_BIT);
}

TEST(HeadlessDisplays, ShowWhatWasDrawnLast) {
  ManualClock clock(kNoon);
  auto display = must(headless(clock));
  EXPECT_THAT(display->description(), HasSubstr("headless 8x6"));
  EXPECT_EQ(display->read().error().kind, FaultKind::bad_input);  // nothing has been shown yet

  for (const Rgb8 colour : {Rgb8{200, 10, 30}, Rgb8{1, 2, 3}, Rgb8{255, 255, 0}}) {
    const auto target = must(display->begin(clock.now()));
    EXPECT_EQ(target->width, 8);
    EXPECT_EQ(target->height, 6);
    fill(*target, colour);
    ASSERT_TRUE(display->show().has_value());
    const auto picture = must(display->read());
    EXPECT_THAT(picture->elements(), testing::Each(colour));
  }
}

TEST(HeadlessDisplays, HaveNoDepthBufferWhichNothingDrawnToThemNeeds) {
  ManualClock clock(kNoon);
  auto display = must(headless(clock));
  glBindFramebuffer(GL_FRAMEBUFFER, must(display->begin(clock.now()))->framebuffer);
  GLint bits = -1;
  glGetIntegerv(GL_DEPTH_BITS, &bits);
  EXPECT_EQ(bits, 0);
}

TEST(HeadlessDisplays, KeepShowingThePictureWhileTheNextIsDrawn) {
  ManualClock clock(kNoon);
  auto display = must(headless(clock));
  fill(*display->begin(clock.now()), {40, 50, 60});
  ASSERT_TRUE(display->show().has_value());
  fill(*display->begin(clock.now()), {90, 90, 90});
  EXPECT_THAT(display->read()->elements(), testing::Each(Rgb8{40, 50, 60}));
}

TEST(HeadlessDisplays, FlipImmediatelyByTheirClock) {
  ManualClock clock(kNoon);
  auto display = must(headless(clock));
  EXPECT_THAT(display->take_flips(), testing::IsEmpty());
  std::vector<Instant> shown_at;
  std::vector<std::uint64_t> numbers;
  for (int i = 0; i < 3; ++i) {
    clock.advance(std::chrono::milliseconds(16));
    ASSERT_TRUE(display->begin(clock.now()).has_value());
    numbers.push_back(display->show().value());
    shown_at.push_back(clock.now());
  }
  const std::vector<Flip> flips = display->take_flips();
  ASSERT_EQ(flips.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(flips[i].number, numbers[i]);
    EXPECT_EQ(flips[i].at, shown_at[i]);
  }
  EXPECT_THAT(numbers, testing::ElementsAre(1, 2, 3));
  EXPECT_THAT(display->take_flips(), testing::IsEmpty());
}

TEST(HeadlessDisplays, HoldTheCamerasBufferUntilThePictureIsReplaced) {
  ManualClock clock(kNoon);
  auto display = must(headless(clock));
  auto first = std::make_shared<int>(1);
  const std::weak_ptr<int> first_held = first;
  ASSERT_TRUE(display->begin(clock.now()).has_value());
  ASSERT_TRUE(display->show(std::move(first)).has_value());
  EXPECT_FALSE(first_held.expired());
  ASSERT_TRUE(display->begin(clock.now()).has_value());
  EXPECT_FALSE(first_held.expired());  // still on the screen
  auto second = std::make_shared<int>(2);
  const std::weak_ptr<int> second_held = second;
  ASSERT_TRUE(display->show(std::move(second)).has_value());
  EXPECT_TRUE(first_held.expired());
  display.reset();
  EXPECT_TRUE(second_held.expired());
}

TEST(HeadlessDisplays, RefuseASizeNoDriverHas) {
  ManualClock clock(kNoon);
  const auto display = open_headless_display({.width = 0, .height = 100}, clock);
  ASSERT_FALSE(display);
  EXPECT_EQ(display.error().kind, FaultKind::bad_input);
  EXPECT_THAT(display.error().message, HasSubstr("0 x 100"));
}

TEST(WindowDisplays, FlipWithTheWindow) {
  ManualClock clock(kNoon);
  auto display = open_window_display({.title = "Kasumi test", .width = 120, .height = 80}, clock);
  std::optional<EnvironmentVariable> driver;
  if (!display) {
    const std::string no_display = display.error().message;
    // SDL's offscreen driver still provides a context where EGL does.
    driver.emplace("SDL_VIDEODRIVER", "offscreen");
    display = open_window_display({.title = "Kasumi test", .width = 120, .height = 80}, clock);
    if (!display) GTEST_SKIP() << no_display << "; " << display.error().message;
  }
  EXPECT_THAT((*display)->description(), HasSubstr("window 120x80"));
  auto held = std::make_shared<int>(1);
  const std::weak_ptr<int> still_held = held;
  const auto target = must((*display)->begin(clock.now()));
  EXPECT_FALSE(target->top_row_first);
  fill(*target, {10, 200, 30});
  ASSERT_EQ((*display)->show(std::move(held)).value(), 1u);
  EXPECT_FALSE(still_held.expired());
  ASSERT_TRUE((*display)->begin(clock.now()).has_value());
  ASSERT_EQ((*display)->show().value(), 2u);
  EXPECT_TRUE(still_held.expired());
  EXPECT_EQ((*display)->take_flips().size(), 2u);
}

}  // namespace
}  // namespace kasumi
