// The building in the evening, when a hill takes its sun: drawn by the slow spectral path with the hill in the scene,
// and by kasumi, which knows the hill by a table of its skyline. World: generated.
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "estimator/sky/sun.hpp"
#include "pipeline/site/config/fixture_file.hpp"
#include "pipeline/site/files/photograph_file.hpp"
#include "tests/figures.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/recorded.hpp"
#include "tests/pipeline/replayed.hpp"

namespace kasumi {
namespace {

constexpr double kHalfHeight_m = 8.0;  // of the building

// An afternoon of October whose sun goes down behind a hill for a building 3.5 km away.
fixtures::Recipe evening() {
  auto recipe = small("clear-noon", 1);
  recipe.scene_width = 240;
  recipe.scene_height = 135;
  recipe.sky_size = 240;
  recipe.noise = false;
  recipe.start_utc = Utc(std::chrono::sys_days(std::chrono::year{2026} / 10 / 20)) + std::chrono::minutes(7 * 60 + 30);
  recipe.hill = fixtures::Hill{250.0, 1500.0, 330.0, 8.0, 80.0};
  for (double t = 0.0; t <= 1500.0; t += 300.0) recipe.times_s.push_back(t);
  recipe.truth_frames = static_cast<int>(recipe.times_s.size());
  return recipe;
}

glm::dvec3 middle_of(const Installation& installation) {
  const auto& place = installation.object.placement;
  return {place.east_m, place.north_m, place.up_m + kHalfHeight_m};
}

// Where the generator's sun would be half behind its hill, as a surveyor would find it from the building.
std::string surveyed(const fixtures::Hill& hill, const glm::dvec3& from) {
  std::string table = "azimuth_deg,elevation_deg\n";
  for (int azimuth_deg = 0; azimuth_deg < 360; ++azimuth_deg) {
    double low = 0.0, high = 60.0;
    for (int i = 0; i < 30; ++i) {
      const double middle = 0.5 * (low + high);
      const auto sun = direction_from(from_degrees(90.0 - middle), from_degrees(double(azimuth_deg)));
      (hill.sunlight_at(from, sun) > 0.5 ? high : low) = middle;
    }
    table += fmt::format("{},{:.3f}\n", azimuth_deg, low);
  }
  return table;
}

// Of each picture, the mean error over the pixels that the building covers, levels of 255.
std::vector<double> errors_of(const std::filesystem::path& fixture, std::size_t pictures) {
  const auto out = test_folder("hills-shade-out");
  must(replay({fixture, out, false, false, {}, {}}));
  const auto picture = [](const std::filesystem::path& path) { return read_photograph(path).value().encoded; };
  std::vector<double> errors;
  for (std::size_t i = 0; i < pictures; ++i) {
    const auto ours = picture(out / fmt::format("frame-{:06}.png", i));
    const auto truth = picture(fixture / "truth" / fmt::format("composite-{:06}.png", i));
    const auto coverage = picture(fixture / "truth" / fmt::format("coverage-{:06}.png", i));
    auto wholly = coverage;
    for (auto& share : wholly.elements()) share = glm::floor(share);
    const auto off = covered_difference(ours, truth, wholly);
    EXPECT_GT(off.pixels, 100.0);
    errors.push_back(off.mean);
  }
  return errors;
}

TEST(HillsShade, TheBuildingLiesInItAsTheLandAroundDoes) {
  const auto recipe = evening();
  const auto fixture = recorded(recipe, "hills-shade");
  const auto installation = read_fixture(fixture).value().installation;
  const auto middle = middle_of(installation);
  const auto pictures = recipe.times_s.size();
  const auto unaware = errors_of(fixture, pictures);
  const auto text = read_text_file(fixture / "fixture.toml").value();
  const std::string object = "[object]\n";
  const auto at = text.find(object) + object.size();
  ASSERT_TRUE(write_text_file(fixture / "skyline.csv", surveyed(*recipe.hill, middle)));
  ASSERT_TRUE(
      write_text_file(fixture / "fixture.toml", text.substr(0, at) + "skyline = \"skyline.csv\"\n" + text.substr(at)));
  const auto aware = errors_of(fixture, pictures);
  ASSERT_EQ(aware.size(), unaware.size());
  int in_shade = 0;
  for (std::size_t i = 0; i < aware.size(); ++i) {
    const auto sun = sun_position(recipe.start_utc + from_seconds(recipe.times_s[i]), recipe.site).direction;
    const double sunlight = recipe.hill->sunlight_at(middle, sun);
    fmt::print("after {:4.0f} s, {:3.0f} % of the sun at its middle: {:.2f} of 255 off, without the table {:.2f}\n",
               recipe.times_s[i], 100.0 * sunlight, aware[i], unaware[i]);
    figure_row("hills-shade",
               {fmt::format("{:.0f} min", recipe.times_s[i] / 60.0), fmt::format("{:.0f} %", 100.0 * sunlight),
                figure_text(aware[i], 1), figure_text(unaware[i], 1)});
    // While the disc sets, the generator's shade climbs the building, which ours takes as a whole.
    const bool setting = sunlight > 0.02 && sunlight < 0.98;
    EXPECT_LE(aware[i], setting ? unaware[i] : 3.0) << recipe.times_s[i];
    if (sunlight > 0.02) continue;
    ++in_shade;
    EXPECT_GT(unaware[i], 3.0 * aware[i]) << recipe.times_s[i];
  }
  EXPECT_GT(in_shade, 0);
  EXPECT_LT(in_shade, static_cast<int>(aware.size()));
}

}  // namespace
}  // namespace kasumi
