#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "base/clock.hpp"
#include "base/latest_slot.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;

TEST(Clock, AManualClockWakesASleeperOnlyWhenAdvancedFarEnough) {
  ManualClock clock(Utc{});
  std::atomic<bool> awake = false;
  std::thread sleeper([&] {
    clock.sleep_until(Instant{10s});
    awake = true;
  });
  clock.advance(9s);
  EXPECT_FALSE(awake);
  clock.advance(1s);
  sleeper.join();
  EXPECT_TRUE(awake);
  EXPECT_EQ(clock.utc(), Utc{10s});
}

TEST(Clock, InterruptWakesCurrentAndLaterSleepers) {
  SystemClock clock;
  std::thread sleeper([&] { clock.sleep_until(clock.now() + 1h); });
  clock.interrupt();
  sleeper.join();
  clock.sleep_until(clock.now() + 1h);
}

TEST(Clock, AFastForwardClockJumpsAndNeverRunsBackwards) {
  FastForwardClock clock(Utc{});
  clock.sleep_until(Instant{5s});
  clock.sleep_until(Instant{3s});
  EXPECT_EQ(clock.now(), Instant{5s});
}

TEST(LatestSlot, TheNewestValueWinsAndDropsAreCounted) {
  LatestSlot<int> slot;
  EXPECT_FALSE(slot.take());
  slot.put(1);
  slot.put(2);
  slot.put(3);
  EXPECT_EQ(slot.take(), 3);
  EXPECT_FALSE(slot.take());
  EXPECT_EQ(slot.dropped(), 2u);
}

}  // namespace
}  // namespace kasumi
