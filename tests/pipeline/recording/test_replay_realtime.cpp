// The recording in real time, with the sky in a thread of its own.
#include <gtest/gtest.h>

#include "pipeline/recording/replay.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {
namespace {

TEST(Replay, InRealTimeTheSkyRunsInParallelWithTheScene) {
  auto recipe = small_scene("clear-noon", 3);
  recipe.sky_period_s = recipe.scene_period_s = 0.2;
  const auto fixture = recorded(recipe, "realtime");
  const auto summary = replay({fixture, test_folder("realtime-out"), false, true, std::nullopt, {}});
  ASSERT_TRUE(summary) << summary.error().message;
  EXPECT_EQ(summary->pictures, 3u);
  EXPECT_EQ(summary->sky_frames, 3u);
}

}  // namespace
}  // namespace kasumi
