// When what was learnt is written to a disk that wears.
#include <gtest/gtest.h>

#include "pipeline/kiosk/start/remembered_state.hpp"
#include "tests/pipeline/kiosk/appliance/rig.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {
namespace {

TEST(RememberedState, IsWrittenAfterANewReadingOnly) {
  const auto folder = test_folder("remembered-state");
  std::filesystem::create_directories(folder);
  const auto file = folder / "turbidity.json";
  std::filesystem::remove(file);
  TurbidityState state{{3.0}, 0.2, Utc{1'800'000'000s}};
  ASSERT_TRUE(save(state, folder));
  const auto written = std::filesystem::last_write_time(file);
  state.sigma = 0.3;   // of the same reading, later
  state.utc += 900ms;  // as well as it is known
  ASSERT_TRUE(save(state, folder));
  EXPECT_EQ(std::filesystem::last_write_time(file), written);
  state.utc += 3s;
  ASSERT_TRUE(save(state, folder));
  EXPECT_NE(std::filesystem::last_write_time(file), written);
  EXPECT_EQ(load_turbidity_state(folder)->sigma, 0.3);
  const auto second = std::filesystem::last_write_time(file);
  state.aerosol = "desert";  // T of another dome
  ASSERT_TRUE(save(state, folder));
  EXPECT_NE(std::filesystem::last_write_time(file), second);
}

TEST(RememberedState, ANightWritesNothing) {
  const auto rig = running({.name = "state-at-night"});
  const auto file = rig->folder / "state" / "turbidity.json";
  const auto time_of = [&] {
    std::error_code error;
    return std::filesystem::last_write_time(file, error);
  };
  rig->advance(15s, 500ms);
  const auto by_day = time_of();
  rig->advance(15s, 500ms);
  EXPECT_NE(time_of(), by_day) << "saved every ten seconds while the sky is read";
  rig->devices.sky.unplugged = true;
  rig->advance(15s, 500ms);
  const auto at_dusk = time_of();
  rig->advance(60s, 500ms);
  EXPECT_EQ(time_of(), at_dusk);
  rig->devices.sky.unplugged = false;
  rig->advance(40s, 500ms);
  EXPECT_NE(time_of(), at_dusk);
}

}  // namespace
}  // namespace kasumi
