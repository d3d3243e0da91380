// Scenes of the physical world, drawn by the spectral atmosphere with Mie's kinds of aerosol, and the building as kasumi
// composites it: with the air given, and with the aerosol's amount found by the dome where the kind is given.
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "tests/figures.hpp"
#include "tests/pipeline/lab/recording/building_scenes.hpp"
#include "tests/pipeline/replayed.hpp"

namespace kasumi {
namespace {

using Scene = BuildingScene;

Scene under(double turbidity, Utc time) {
  return kasumi::under(pictured("clear-noon", 240), turbidity, time, 2.0, 2.0);
}
Scene in_air(std::string_view preset, double goal) {
  return {std::string(preset), pictured(preset, 240), goal, goal};
}

// Goals that pictures this small do not reach: edges and the camera's noise are most of the error, no channel is off by
// more than 2 in the mean. At four times the pixels broken-clouds comes to 1.5.
Scene beyond_its_goal(std::string_view preset, double goal, double held) {
  Scene scene = in_air(preset, goal);
  scene.held = held;
  return scene;
}

// The fixture says which kind of aerosol hangs in its air; this adds how much, in the place of "auto".
void tell_amount(const std::filesystem::path& fixture, double aod_550) {
  std::string text = read_text_file(fixture / "fixture.toml").value();
  const std::string found = "aod_550 = \"auto\"";
  const auto at = text.find(found);
  ASSERT_NE(at, std::string::npos);
  text.replace(at, found.size(), fmt::format("aod_550 = {}", aod_550));
  ASSERT_TRUE(write_text_file(fixture / "fixture.toml", text));
}

void expect_right(const std::vector<Scene>& scenes) {
  std::string table =
      "| scene | building's error, of 255, air given | amount found | goal, given |\n|---|---|---|---|\n";
  for (const Scene& scene : scenes) {
    const auto fixture = recorded(scene.recipe, "air-truth"), out = test_folder("air-truth-out");
    const auto error = [&](const char* how) {
      played(fixture, out);
      return building_error(fixture, out, scene.name + how);
    };
    const double found = error(", amount found");
    tell_amount(fixture, scene.recipe.aerosol.value_or(aerosol_of(scene.recipe.turbidity)).aod_550);
    const double given = error(", given");
    table += fmt::format("| {} | {:.2f} | {:.2f} | {} |\n", scene.name, given, found, scene.goal);
    figure_row("given-building",
               {scene.name, figure_text(given, 1), figure_text(found, 1), fmt::format("{}", scene.goal)});
    EXPECT_LE(given, scene.held) << scene.name;
  }
  fmt::print("{}", table);
}

TEST(AirTruthScenes, UnderAPhysicalSkyOfKnownAirTheBuildingIsRight) {
  const std::vector all{under(2.4, kSun62DegHigh),           under(4.0, kSun62DegHigh),
                        under(7.0, kSun62DegHigh),           under(2.4, kSun31DegHigh),
                        under(4.0, kSun31DegHigh),           under(7.0, kSun31DegHigh),
                        in_air("clear-alpine", 2.0),         beyond_its_goal("broken-clouds", 2.0, 2.2),
                        beyond_its_goal("sun-low", 2.0, 2.3)};
  expect_right(figure_cases("scenes", {all[1], all[5]}, all));
}

TEST(AirTruthScenes, InDustSmokeAndMistOfKnownAirTheBuildingIsRight) {
  const std::vector all{in_air("dust", 3.0), in_air("smoke", 3.0), in_air("sea-mist", 3.0)};
  expect_right(figure_cases("airs", {all[0]}, all));
}

}  // namespace
}  // namespace kasumi
