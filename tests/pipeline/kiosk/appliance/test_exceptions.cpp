// Exceptions that reach a loop: what is lost, and how soon it is back.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <new>
#include <stdexcept>

#include "pipeline/kiosk/loop/loop_guard.hpp"
#include "tests/pipeline/kiosk/appliance/rig.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {
namespace {

TEST(LoopGuard, AStepThatThrowsIsTakenAgainAfterLongerAndLongerPauses) {
  ManualClock clock(Utc{});
  LoopGuard guard("loop", clock);
  EXPECT_TRUE(guard.run([] {}));
  std::vector<Duration> pauses;
  for (int i = 0; i < 6; ++i) {
    EXPECT_FALSE(guard.run([&] {
      if (i % 2 == 0) throw std::bad_alloc();
      throw i;  // by a library that has exceptions of its own
    }));
    pauses.push_back(guard.again_at() - clock.now());
  }
  EXPECT_THAT(pauses, testing::ElementsAre(1s, 2s, 3s, 3s, 3s, 3s));
  EXPECT_TRUE(guard.run([] {}));
  EXPECT_FALSE(guard.run([] { throw std::runtime_error("again"); }));
  EXPECT_EQ(guard.again_at() - clock.now(), 1s);
}

TEST(Exceptions, Row37DrawingWithoutMemoryOpensTheDisplayAnewAndLeavesTheRestToTheWatchdog) {
  const auto rig = running({.name = "row37-drawing"});
  auto& display = rig->devices.display;
  const auto opened = display.opened;
  display.throws = true;
  rig->advance(3s, 500ms);  // each step opens a display and makes a stage
  EXPECT_GT(display.opened, opened);
  const auto alives = rig->notifier.alives;
  rig->advance(5s, 500ms);
  EXPECT_LE(rig->notifier.alives - alives, 1) << "without a picture the watchdog restarts";
  display.throws = false;
  EXPECT_TRUE(rig->recover("37 memory for drawing again", 2s));
}

TEST(Exceptions, Row37StateThatCannotBeReadBeginsAnewAndContentIsRefused) {
  RigOptions options{.name = "row37", .more_config = kAWood, .keep_folder = true};
  const auto state = test_folder("appliance-" + options.name) / "state";
  std::filesystem::remove_all(state.parent_path());
  std::filesystem::create_directories(state);
  make_unreadable(state / "turbidity.json");
  make_unreadable(state / "landmarks.json");
  const auto rig = running(options);
  make_unreadable(rig->folder / "temple.glb");
  rig->hang_up();
  ASSERT_TRUE(rig->advance_until([&] { return rig->status().reload && !rig->status().reload->problems.empty(); }, 5s));
  EXPECT_THAT(rig->status().reload->problems,
              testing::Contains(testing::HasSubstr("temple.glb: cannot be read: Input/output error")));
  EXPECT_EQ(rig->shown(), Shown::live);
}

}  // namespace
}  // namespace kasumi
