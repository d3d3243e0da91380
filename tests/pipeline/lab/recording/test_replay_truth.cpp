// End to end from a recording of Preetham's world to the picture, compared with its known truth: turbidity, and the
// building drawn by the slow spectral path. test_air_truth_scenes does the same in the physical world.
#include <gtest/gtest.h>

#include "tests/csv.hpp"
#include "tests/figures.hpp"
#include "tests/pipeline/recorded.hpp"
#include "tests/pipeline/replayed.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

// Sky frames and truth are listed by time; each estimate is compared with the truth at its time.
void expect_turbidity(const std::filesystem::path& fixture, const std::filesystem::path& out, double tolerance) {
  const auto estimates = read_csv(out / "turbidity.csv");
  const auto truth = read_csv(fixture / "truth" / "truth.csv");
  ASSERT_FALSE(estimates.empty());
  int compared = 0;
  for (const auto& estimate : estimates)
    for (const auto& true_row : truth) {
      if (true_row.at("utc") != estimate.at("utc")) continue;
      EXPECT_EQ(estimate.at("usable"), "true") << estimate.at("reason");
      if (estimate.at("usable") != "true") continue;
      EXPECT_NEAR(std::stod(estimate.at("turbidity")), std::stod(true_row.at("turbidity")), tolerance)
          << estimate.at("utc");
      ++compared;
    }
  EXPECT_EQ(compared, static_cast<int>(estimates.size()));
}

fixtures::Recipe of_the_papers(fixtures::Recipe recipe) {
  recipe.world = fixtures::World::preetham;
  return recipe;
}

TEST(ReplayTruth, TurbidityOfClearFixturesIsFoundWithinATenth) {
  for (const char* preset : {"clear-noon", "sun-low"}) {
    SCOPED_TRACE(preset);
    const auto fixture = recorded(of_the_papers(small_scene(preset, 3)), std::string("truth-") + preset);
    const auto out = test_folder(std::string("truth-out-") + preset);
    const auto summary = played(fixture, out);
    EXPECT_EQ(summary.pictures, 3u);
    expect_turbidity(fixture, out, 0.1);
  }
}

TEST(ReplayTruth, ARisingTurbidityIsFollowed) {
  const auto fixture = recorded(of_the_papers(small_scene("turbidity-change", 6)), "change");
  const auto out = test_folder("change-out");
  played(fixture, out);
  expect_turbidity(fixture, out, 0.1);
}

TEST(ReplayTruth, TheBuildingsPixelsComeWithinTwoLevelsOfTheSpectralReference) {
  for (const char* preset :
       figure_cases<const char*>("skies", {"papers-clouds"}, {"papers-noon", "papers-haze", "papers-clouds"})) {
    SCOPED_TRACE(preset);
    auto recipe = fixtures::recipe_of(preset).value();
    recipe.sky_frames = recipe.scene_frames = recipe.truth_frames = 1;
    const auto fixture = recorded(recipe, std::string("composite-") + preset);
    const auto out = test_folder(std::string("composite-out-") + preset);
    played(fixture, out);
    EXPECT_LE(building_error(fixture, out, preset, "pictures"), 2.0);
  }
}

TEST(ReplayTruth, InTheDemoThinCloudsAtTheHorizonDoNotColourTheBuilding) {
  const std::filesystem::path fixture = source_folder() / "fixtures" / "demo";
  const auto out = test_folder("composite-out-demo");
  ASSERT_TRUE(replay({fixture, out, false, false, 1, {}}));
  EXPECT_LE(building_error(fixture, out, "demo", "pictures"), 5.0) << "the noise of its camera included";
  EXPECT_LE(building_error(fixture, out, "demo, means of 5 x 5 pixels", "pictures", 5), 2.2);
}

}  // namespace
}  // namespace kasumi
