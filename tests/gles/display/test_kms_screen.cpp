// The KMS display on a real driver: in the virtual machine, or on a machine whose screen nothing else uses. Skipped
// where there is no card; with KASUMI_KMS_DEVICE=/dev/dri/card0 an unusable card is a failure.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "gles/display/display_listing.hpp"
#include "gles/display/kms_system.hpp"
#include "gles/gl/gl.hpp"
#include "tests/gles/display/display_helpers.hpp"
#include "tests/gles/display/kms_decorator.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;
using namespace std::chrono_literals;

// Quarters from the top left: red, green, blue, white; a grey square in the middle.
void draw_test_pattern(const DrawTarget& target) {
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
  glViewport(0, 0, target.width, target.height);
  glEnable(GL_SCISSOR_TEST);
  const auto fill = [&](int left, int top, int width, int height, float r, float g, float b) {
    const int row = target.top_row_first ? top : target.height - top - height;
    glScissor(left, row, width, height);
    glClearColor(r, g, b, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT);
  };
  const int w = target.width / 2, h = target.height / 2;
  fill(0, 0, w, h, 1, 0, 0);
  fill(w, 0, target.width - w, h, 0, 1, 0);
  fill(0, h, w, target.height - h, 0, 0, 1);
  fill(w, h, target.width - w, target.height - h, 1, 1, 1);
  fill(w - h / 4, h - h / 4, h / 2, h / 2, 0.5f, 0.5f, 0.5f);
  glDisable(GL_SCISSOR_TEST);
}

class KmsScreen : public testing::TestWithParam<bool> {
 protected:
  static KmsDisplayOptions options() {
    const char* device = std::getenv("KASUMI_KMS_DEVICE");
    KmsDisplayOptions options;
    options.device = device == nullptr ? "" : device;
    options.atomic = GetParam();
    return options;
  }
  void SetUp() override {
    auto display = open_kms_display(options(), clock_);
    if (display) return;
    if (std::getenv("KASUMI_KMS_DEVICE") != nullptr) FAIL() << display.error().message;
    GTEST_SKIP() << "no unused screen here: " << display.error().message;
  }
  std::unique_ptr<Display> open(std::shared_ptr<KmsSystem> system = open_kms_system()) {
    auto display = open_kms_display(options(), clock_, std::move(system));
    EXPECT_TRUE(display.has_value()) << display.error().message;
    return display ? std::move(*display) : nullptr;
  }
  Result<std::uint64_t> show_pattern(Display& display, std::shared_ptr<const void> holder = nullptr) {
    const auto target = display.begin(clock_.now() + 3s);
    if (!target) return fail(target.error());
    draw_test_pattern(*target);
    return display.show(std::move(holder));
  }
  static double ms(Duration duration) { return 1e3 * to_seconds(duration); }

  SystemClock clock_;
};

TEST_P(KmsScreen, ShowsTheTestPattern) {
  auto display = must(open());
  std::printf("%s\n", display->description().c_str());
  EXPECT_THAT(display->description(), HasSubstr(GetParam() ? "atomic" : "legacy"));
  const Instant before = clock_.now();
  ASSERT_EQ(show_pattern(*display).value(), 1u);
  ASSERT_TRUE(display->begin(clock_.now() + 3s).has_value());
  const auto flips = display->take_flips();
  ASSERT_EQ(flips.size(), 1u);
  EXPECT_GE(flips[0].at, before);
  EXPECT_LE(flips[0].at, clock_.now());
  EXPECT_EQ(display->counts().modesets, 1u);
  if (const char* hold_s = std::getenv("KASUMI_KMS_HOLD_S")) {  // for an observer who captures the screen from outside
    std::printf("the pattern is on the screen\n");
    std::fflush(stdout);
    std::this_thread::sleep_for(std::chrono::duration<double>(std::atof(hold_s)));
  }
}

TEST_P(KmsScreen, FlipsEveryPictureInOrder) {
  auto display = must(open());
  const auto timing = must(measure_flips(*display, clock_, 100));
  std::printf("%s: %d flips, every %.2f ms (median), %.2f ms (longest); %.2f ms from show to flip (median)\n",
              display->description().c_str(), timing->flips, ms(timing->median_interval), ms(timing->longest_interval),
              ms(timing->median_latency));
  EXPECT_EQ(timing->flips, 100);
  EXPECT_EQ(display->counts().flip_timeouts, 0u);
}

TEST_P(KmsScreen, ReleasesTheCamerasBufferWithTheFlipThatReplacesIt) {
  auto display = must(open());
  std::vector<std::weak_ptr<int>> holders;
  for (int i = 0; i < 20; ++i) {
    auto holder = std::make_shared<int>(i);
    holders.push_back(holder);
    ASSERT_TRUE(show_pattern(*display, std::move(holder)).has_value());
    ASSERT_TRUE(display->begin(clock_.now() + 3s).has_value());
    EXPECT_FALSE(holders.back().expired()) << "picture " << i << " is on the screen";
    for (int before = 0; before < i; ++before)
      EXPECT_TRUE(holders[static_cast<std::size_t>(before)].expired()) << "picture " << before << " was replaced";
  }
}

TEST_P(KmsScreen, ReopensWithoutLeakingDescriptors) {
  ASSERT_TRUE(show_pattern(*open()).has_value());  // what the libraries keep permanently is allocated now
  const std::size_t before = open_descriptors();
  for (int i = 0; i < 10; ++i) {
    auto display = must(open());
    for (int picture = 0; picture < 4; ++picture) ASSERT_TRUE(show_pattern(*display).has_value());
  }
  EXPECT_EQ(open_descriptors(), before);
}

TEST_P(KmsScreen, BelongsToOneHolderAtATime) {
  auto display = must(open());
  EXPECT_THAT(open_kms_display(options(), clock_), FailsAs(FaultKind::device, HasSubstr("DRM master")));
}

TEST_P(KmsScreen, ListsItsModesWhenTheRequestedOneIsMissing) {
  KmsDisplayOptions strange = options();
  strange.width = 1234;
  strange.height = 567;
  EXPECT_THAT(open_kms_display(strange, clock_),
              FailsAs(FaultKind::bad_input, testing::AllOf(HasSubstr("1234x567"), HasSubstr("(preferred)"))));
  strange.preferred_instead = true;
  const auto taken = must(open_kms_display(strange, clock_));
  EXPECT_THAT((*taken)->description(), HasSubstr("not offered"));
}

TEST_P(KmsScreen, ReportsWhenItIsNoLongerMaster) {
  auto system = std::make_shared<DecoratedSystem>();
  auto display = must(open(system));
  ASSERT_TRUE(show_pattern(*display).has_value());
  ASSERT_TRUE(show_pattern(*display).has_value());
  ASSERT_TRUE(display->begin(clock_.now() + 3s).has_value());
  system->last->drop_master();
  const Instant taken = clock_.now();
  Result<std::uint64_t> shown = 0u;
  while (shown && clock_.now() < taken + 5s) shown = show_pattern(*display);
  ASSERT_FALSE(shown);
  EXPECT_EQ(shown.error().kind, FaultKind::device);
  EXPECT_THAT(shown.error().message, HasSubstr("DRM master"));
  std::printf("lost master: reported after %.1f ms\n", ms(clock_.now() - taken));
  display.reset();
  auto again = must(open());
  ASSERT_TRUE(show_pattern(*again).has_value());
}

TEST_P(KmsScreen, SetsTheModeAgainAfterALostFlip) {
  auto system = std::make_shared<DecoratedSystem>();
  auto display = must(open(system));
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(show_pattern(*display).has_value());
  ASSERT_TRUE(display->begin(clock_.now() + 3s).has_value());
  system->last->lost_events = 1;
  const Instant lost = clock_.now();
  ASSERT_TRUE(show_pattern(*display).has_value());
  const auto target = display->begin(clock_.now() + 5s);
  ASSERT_TRUE(target.has_value()) << target.error().message;
  std::printf("lost flip: recovered after %.0f ms\n", ms(clock_.now() - lost));
  EXPECT_LE(clock_.now() - lost, 2s);
  EXPECT_EQ(display->counts().flip_timeouts, 1u);
  EXPECT_EQ(display->counts().modesets, 2u);
  EXPECT_EQ(display->counts().flips, 4u);
}

// Through the kernel's own connector override, which root may write.
TEST_P(KmsScreen, ComesBackWhenTheDisplayDoes) {
  std::string card, connector;
  for (const auto& listed : list_displays())
    for (const auto& one : listed.connectors)
      if (connector.empty() && one.connection == "connected") {
        card = std::filesystem::path(listed.path).filename();
        connector = one.name;
      }
  const std::filesystem::path status = "/sys/class/drm/" + card + "-" + connector + "/status";
  const auto force = [&](const char* word) {
    std::ofstream file(status);
    file << word << std::flush;
    return static_cast<bool>(file);
  };
  auto display = must(open());
  ASSERT_TRUE(show_pattern(*display).has_value());
  if (!force("off")) GTEST_SKIP() << status << " cannot be written";
  const Instant pulled = clock_.now();
  Result<std::uint64_t> shown = 0u;
  while (shown && clock_.now() < pulled + 5s) shown = show_pattern(*display);
  const Instant reported = clock_.now();
  display.reset();
  const auto without = open_kms_display(options(), clock_);
  force("detect");
  const Instant plugged = clock_.now();
  ASSERT_FALSE(shown);
  EXPECT_EQ(shown.error().kind, FaultKind::disconnected) << shown.error().message;
  ASSERT_FALSE(without);
  EXPECT_EQ(without.error().kind, FaultKind::disconnected) << without.error().message;
  std::printf("unplugged: reported after %.0f ms (%s)\n", ms(reported - pulled), without.error().message.c_str());
  display = open();
  ASSERT_TRUE(display);
  ASSERT_TRUE(show_pattern(*display).has_value());
  ASSERT_TRUE(display->begin(clock_.now() + 3s).has_value());
  std::printf("plugged in again: picture after %.0f ms\n", ms(clock_.now() - plugged));
  EXPECT_LE(reported - pulled, 3s);
  EXPECT_LE(clock_.now() - plugged, 3s);
}

TEST(KmsListings, NameEveryCardWithItsConnectors) {
  const auto cards = list_displays();
  if (cards.empty()) GTEST_SKIP() << "no card here";
  for (const ListedCard& card : cards) {
    std::printf("%s (%s) %s%s %s\n", card.path.c_str(), card.by_path.c_str(), card.driver.c_str(),
                card.atomic ? ", atomic" : "", (card.problem + card.users).c_str());
    EXPECT_FALSE(card.path.empty());
    EXPECT_EQ(card.driver.empty(), !card.problem.empty());
    for (const ListedConnector& connector : card.connectors) {
      std::printf("  %s: %s, \"%s\", now %s, preferred %s, %zu modes\n", connector.name.c_str(),
                  connector.connection.c_str(), connector.display.c_str(), connector.mode_now.c_str(),
                  connector.preferred.c_str(), connector.modes.size());
      EXPECT_EQ(connector.preferred.empty(), connector.modes.empty());
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, KmsScreen, testing::Bool(),
                         [](const auto& which) { return std::string(which.param ? "Atomic" : "Legacy"); });

}  // namespace
}  // namespace kasumi
