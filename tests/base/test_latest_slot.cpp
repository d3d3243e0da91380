#include "base/latest_slot.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <future>
#include <memory>

namespace kasumi {
namespace {

using namespace std::chrono_literals;

TEST(LatestSlot, TheNewestValueIsHandedOverOnceAndDroppedOnesAreCounted) {
  LatestSlot<int> slot;
  EXPECT_FALSE(slot.take());
  slot.put(1);
  slot.put(2);
  EXPECT_EQ(slot.take(), 2);
  EXPECT_FALSE(slot.take());
  EXPECT_EQ(slot.dropped(), 1u);
  slot.put(3);
  EXPECT_EQ(slot.dropped(), 1u);
}

// A frame that nobody fetched goes back to its driver, which may take its time.
TEST(LatestSlot, AReplacedValueEndsWithoutTheLock) {
  LatestSlot<std::shared_ptr<const void>> slot;
  bool free = false;
  std::future<std::uint64_t> other;
  slot.put(std::shared_ptr<const void>(&slot, [&](const void*) {
    other = std::async(std::launch::async, [&] { return slot.dropped(); });
    free = other.wait_for(2s) == std::future_status::ready;
  }));
  slot.put(nullptr);
  EXPECT_TRUE(free) << "another thread waits for a driver";
  EXPECT_EQ(other.get(), 1u);
}

}  // namespace
}  // namespace kasumi
