// When what was learnt is written to a disk that wears, and a start that shows the building as the start before had
// drawn it.
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "gles/gl/context.hpp"
#include "pipeline/kiosk/start/remembered_state.hpp"
#include "tests/pipeline/kiosk/appliance/journal.hpp"
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

constexpr const char* kShownAsBefore = "the building is shown as it was drawn before the start";

class LayerOfBeforeAtStart : public testing::Test {
 protected:
  void SetUp() override {
    const auto context = open_headless_context();
    if (!context || !(*context)->info().software) GTEST_SKIP() << "layers are kept where GL is software";
  }
  static RigOptions options(const std::string& name, Duration later = 0s) {
    return {
        .name = name, .utc = std::chrono::sys_days{std::chrono::June / 21 / 2026} + 3h + later, .observe_every = 200ms};
  }
  static void end(Rig& rig) {
    rig.appliance->render().finish();
    rig.appliance->status().finish();
  }
  // Started again, with all that the first left.
  static RigOptions again(RigOptions options) {
    options.keep_folder = options.keep_content = true;
    return options;
  }
  static std::string kept(const Rig& rig) { return read_text_file(rig.folder / "state" / "layer.bin").value_or(""); }
};

TEST_F(LayerOfBeforeAtStart, IsTheFirstPictureAndReplacedWithinFiveSeconds) {
  Image<Rgb8> last;
  std::string before;
  {
    const auto rig = running(options("layer-of-before"));
    EXPECT_EQ(kept(*rig), "") << "flash memory wears";
    end(*rig);
    before = kept(*rig);
    ASSERT_NE(before, "");
  }
  const Journal journal;
  Rig rig(again(options("layer-of-before", 30s)));
  const auto live = rig.advance_until([&] { return rig.age_on_screen().has_value(); }, 2s);
  ASSERT_TRUE(live);
  EXPECT_EQ(rig.appliance->render().status().pictures, 1u) << "no still picture before it";
  EXPECT_EQ(rig.appliance->render().rung().still, 0.0) << "there was nothing to fade from";
  EXPECT_TRUE(rig.appliance->render().status().building_drawn);
  EXPECT_EQ(journal.count(kShownAsBefore), 1) << journal.text();
  rig.advance(5s - *live);
  end(rig);
  EXPECT_NE(kept(rig), before) << "one of its own";
}

TEST_F(LayerOfBeforeAtStart, Row56IsDrawnAnewWhereItIsOldOrOfOtherContent) {
  for (const std::string what : {"old", "content", "damaged"}) {
    SCOPED_TRACE(what);
    auto first = options("layer-not-of-before");
    {
      const auto rig = running(first);
      end(*rig);
      ASSERT_NE(kept(*rig), "");
      if (what == "damaged") {
        ASSERT_TRUE(write_text_file(rig->folder / "state" / "layer.bin", kept(*rig).substr(0, 5000)));
      }
    }
    const Journal journal;
    auto second = again(options("layer-not-of-before", what == "old" ? 11min : 30s));
    second.keep_content = what != "content";
    Rig rig(second);
    rig.advance(4s);
    EXPECT_EQ(rig.shown(), Shown::live);
    EXPECT_EQ(journal.count(kShownAsBefore), 0) << journal.text();
    EXPECT_EQ(std::filesystem::exists(rig.folder / "state" / "layer.bin"), what == "old");
  }
}

TEST_F(LayerOfBeforeAtStart, IsWrittenEveryTenMinutes) {
  const auto rig = running(options("layer-every-ten-minutes"));
  rig->advance(9min + 30s, 10s);
  EXPECT_EQ(kept(*rig), "");
  rig->advance(40s, 1s);
  const auto first = kept(*rig);
  EXPECT_NE(first, "");
  rig->advance(40s, 1s);
  EXPECT_EQ(kept(*rig), first);
}

}  // namespace
}  // namespace kasumi
