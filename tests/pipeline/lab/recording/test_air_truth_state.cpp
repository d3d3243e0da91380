// The building as kasumi composites it when nobody tells it anything of the air: scenes of the physical world, drawn by
// the spectral atmosphere, whose air is found by the sky camera and by landmarks.
#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "capture/fixture/fixture.hpp"
#include "capture/fixture/fixture_writer.hpp"
#include "estimator/fusion/air_quantities.hpp"
#include "estimator/fusion/air_tracker.hpp"
#include "tests/figures.hpp"
#include "tests/pipeline/lab/recording/building_scenes.hpp"
#include "tests/pipeline/replayed.hpp"

namespace kasumi {
namespace {

using Scene = BuildingScene;
using std::chrono::hours;
using std::chrono::minutes;

// One picture of a sky whose particles may be of any kind: what is believed of the air before it has its part in the
// answer.
constexpr double kHeldByOnePicture = 3.5;

Scene under(double turbidity, Utc time) {
  return kasumi::under(pictured("clear-noon", 480), turbidity, time, 3.0, kHeldByOnePicture);
}
Scene in_air(std::string_view preset) {
  return {std::string(preset), pictured(preset, 480), 3.0, kHeldByOnePicture};
}

// The landmarks' contrasts are not known better than to .05: three of them leave 3 of 255 for one sigma here, which is
// the goal in thin haze. In the thinnest, edges and noise alone leave 2 to 3.
constexpr double kHeldUnderThinHaze = 3.2, kHeldInClearAir = 4.2;

Scene covered(double turbidity, std::uint64_t seed, double goal) {
  auto recipe = pictured("overcast", 480);
  recipe.turbidity = recipe.turbidity_end = turbidity;
  recipe.seed = seed;
  recipe.landmarks = 3;
  return {fmt::format("overcast, three landmarks, T {}, land {}", turbidity, seed), recipe, goal,
          turbidity > 4.0   ? goal
          : turbidity > 3.0 ? kHeldUnderThinHaze
                            : kHeldInClearAir};
}

// A third to a half of what is between camera and building lies in a low layer of 600 m, which no sky camera tells from
// the rest and landmarks see: over a quarter of an hour, in which the one must not run away from the other.
Scene low_haze(double aod_550, double low_per_m, std::uint64_t seed) {
  auto recipe = pictured("clear-noon", 480);
  recipe.aerosol = Aerosol{aod_550, 1.3, AerosolKind::continental};
  recipe.fog = {low_per_m, recipe.site.altitude_m, 600.0};
  recipe.landmarks = 3;
  recipe.seed = seed;
  recipe.sky_frames = recipe.scene_frames = 8;
  recipe.sky_period_s = recipe.scene_period_s = 120.0;
  recipe.truth_frames = recipe.scene_frames;
  return {fmt::format("low haze of 600 m, three landmarks, AOD {}, {} per km more below", aod_550, 1e3 * low_per_m),
          recipe, 5.0, 5.0};
}

// What the generator says of the air is taken back: nothing is known of it, nor of a low haze that landmarks see. Fog
// that nothing shows is left told.
void keep_quiet_about_the_air(const std::filesystem::path& fixture, bool landmarks) {
  std::string text = read_text_file(fixture / "fixture.toml").value();
  const auto from = text.find("sky_model = "), to = text.find("\n", text.find("\naerosol = ") + 1);
  ASSERT_NE(from, std::string::npos);
  ASSERT_LT(from, to);
  text.replace(from, to - from, "sky_model = \"automatic\"");
  if (const auto fog = text.find("[site.fog]"); landmarks && fog != std::string::npos)
    text.erase(fog, text.find("\n", text.find("scale_height_m", fog)) + 1 - fog);
  ASSERT_TRUE(write_text_file(fixture / "fixture.toml", text));
}

Aerosol true_air(const fixtures::Recipe& recipe) {
  return recipe.aerosol.value_or(aerosol_of(recipe.turbidity));
}

double aod_sigma_of(const TrackedAir& state) {
  return std::sqrt(state.air.covariance().aod_550);
}

// Of numbered pictures the last takes the place of the first: what was learnt on the way is seen there.
void take_last(const std::filesystem::path& folder, std::string_view name) {
  const auto file = [&](int n) { return folder / fmt::format("{}-{:06}.png", name, n); };
  int last = 0;
  while (std::filesystem::exists(file(last + 1))) ++last;
  if (last > 0) std::filesystem::rename(file(last), file(0));
}
void take_last_picture(const std::filesystem::path& out) {
  take_last(out, "frame");
}

ReplaySummary played_to_the_last(const std::filesystem::path& fixture, const std::filesystem::path& out) {
  const auto summary = played(fixture, out);
  take_last_picture(out);
  return summary;
}

bool play_under(const Aerosol& aerosol, const std::filesystem::path& fixture, const std::filesystem::path& out) {
  ReplayRequest request{fixture, out, false, false, std::nullopt, {}};
  request.given = {aerosol.aod_550, aerosol.angstrom_exponent, aerosol.kind};
  const auto told = replay(request);
  EXPECT_TRUE(told);
  take_last_picture(out);
  return told.has_value();
}

// By how much the building changes, in levels of 255, when it is drawn under another air.
double change_under(const std::filesystem::path& fixture, const std::filesystem::path& found, const Aerosol& aerosol) {
  const auto out = test_folder("air-state-other");
  if (!play_under(aerosol, fixture, out)) return 0.0;
  return covered_difference(read_photograph(found / "frame-000000.png").value().encoded,
                            read_photograph(out / "frame-000000.png").value().encoded,
                            read_photograph(fixture / "truth" / "coverage-000000.png").value().encoded)
      .mean;
}

// By how much it changes within one sigma of the air on the way.
double one_sigma_of(const std::filesystem::path& fixture, const std::filesystem::path& found, const TrackedAir& state) {
  Aerosol aerosol = state.air.aerosol();
  const double amount = aerosol.aod_550 * state.air.near_ground();
  const double sigma = state.sigma_log_path_amount * (amount + kSmallAerosol);
  aerosol.aod_550 = amount + sigma;
  const double up = change_under(fixture, found, aerosol);
  aerosol.aod_550 = std::max(0.0, amount - sigma);
  return 0.5 * (up + change_under(fixture, found, aerosol));
}

// Who sees how much aerosol alone.
std::string text_of(const std::vector<ObserverPart>& observers) {
  std::string text;
  for (const ObserverPart& part : observers)
    text += fmt::format("{}{} {:.3f} +- {:.3f}", text.empty() ? "" : ", ", name_of(part.by), part.aod_550,
                        part.sigma_aod_550);
  return text.empty() ? "nobody" : text;
}

// With the air given as it is: what is left then is not the air's.
double error_when_given(const std::filesystem::path& fixture, const Aerosol& truth, const std::string& name) {
  const auto out = test_folder("air-state-told");
  return play_under(truth, fixture, out) ? building_error(fixture, out, name + ", given") : 255.0;
}

void expect_right(const std::vector<Scene>& scenes) {
  std::string table =
      "| scene | building's error, of 255 | with the air given | one sigma of the air | goal | AOD: true | found | by "
      "|\n|---|---|---|---|---|---|---|---|\n";
  for (const Scene& scene : scenes) {
    const auto fixture = recorded(scene.recipe, "air-state"), out = test_folder("air-state-out");
    keep_quiet_about_the_air(fixture, scene.recipe.landmarks > 0);
    for (const char* truth : {"composite", "coverage"}) take_last(fixture / "truth", truth);
    const auto summary = played_to_the_last(fixture, out);
    const double error = building_error(fixture, out, scene.name);
    ASSERT_TRUE(summary.last && summary.last->air);
    const TrackedAir& state = *summary.last->air;
    const Aerosol found = state.air.aerosol(), truth = true_air(scene.recipe);
    table += fmt::format(
        "| {} | {:.2f} | {:.2f} | {:.2f} | {} | {:.3f} | {:.3f} +- {:.3f}, near the ground {:.2f}, exponent {:.2f}, "
        "{}, papers {:.2f} | {} |\n",
        scene.name, error, error_when_given(fixture, truth, scene.name), one_sigma_of(fixture, out, state), scene.goal,
        truth.aod_550, found.aod_550, aod_sigma_of(state), state.air.near_ground(), found.angstrom_exponent,
        name_of(found.kind), state.papers_share, text_of(state.observers));
    figure_row("found-building",
               {scene.name, figure_text(error, 1), fmt::format("{}", scene.goal), "`test_air_truth_state`"});
    EXPECT_LE(error, scene.held) << scene.name << ": " << summary.last->estimate.reason;
  }
  fmt::print("{}", table);
}

TEST(AirTruthState, UnderAClosedSkyThreeLandmarksTellTheAir) {
  const std::vector all{covered(4.0, 1, 3.0), covered(8.0, 1, 5.0), covered(2.4, 1, 3.0),
                        covered(4.0, 7, 3.0), covered(8.0, 7, 5.0), covered(6.0, 3, 5.0)};
  expect_right(figure_cases("covered", {all[0], all[1]}, all));
}

TEST(AirTruthState, UnderASkyOfWhichNothingIsKnownTheBuildingIsRight) {
  const std::vector all{under(2.4, kSun62DegHigh), under(4.0, kSun62DegHigh), under(7.0, kSun62DegHigh),
                        under(2.4, kSun31DegHigh), under(4.0, kSun31DegHigh), under(7.0, kSun31DegHigh),
                        in_air("clear-alpine"),    in_air("broken-clouds"),   in_air("sun-low")};
  expect_right(figure_cases("scenes", {all[1], all[5]}, all));
}

TEST(AirTruthState, InLowHazeThatOnlyLandmarksSeeTheBuildingIsRight) {
  const std::vector all{low_haze(0.1, 8e-5, 1), low_haze(0.2, 1.5e-4, 1), low_haze(0.1, 1.5e-4, 7)};
  expect_right(figure_cases("low hazes", {all[0]}, all));
}

TEST(AirTruthState, InDustSmokeAndMistOfWhichNothingIsKnownTheBuildingIsRight) {
  const std::vector all{in_air("dust"), in_air("smoke"), in_air("sea-mist")};
  expect_right(figure_cases("airs", {all[1]}, all));
}

// One camera's frames of a recording, later than they were by the recorder's clock.
void append_frames(FixtureWriter& writer, const std::filesystem::path& camera_folder, Duration later) {
  const auto rows = read_index(camera_folder).value();
  for (const IndexRow& row : rows) {
    const auto bytes = read_file(camera_folder / row.payload).value();
    Frame frame{row.metadata, payload_of(bytes)};
    frame.metadata.captured_at += later;
    ASSERT_TRUE(writer.append(frame));
  }
}

struct CloudsCome {
  std::string name;
  double turbidity;
  std::uint64_t seed;
  bool sky_frames = true;  // false: there was no clear hour
  int landmarks = 0;       // which the clear hour shows, too
};

// A few minutes of clear sky, and one picture an hour later under a closed layer of clouds.
std::filesystem::path clouds_come(const CloudsCome& scene) {
  constexpr auto kLater = hours(1);
  auto clear = pictured("overcast", 480);
  clear.cloud_cover = 0.0;
  clear.turbidity = clear.turbidity_end = scene.turbidity;
  clear.seed = scene.seed;
  clear.sky_frames = 4;
  clear.truth_frames = 0;
  auto covered = pictured("overcast", 480);
  covered.turbidity = covered.turbidity_end = scene.turbidity;
  covered.seed = scene.seed;
  covered.landmarks = scene.landmarks;
  covered.start_utc += kLater;
  const auto before = recorded(clear, "air-state-clear"), after = recorded(covered, "air-state-covered");
  const auto both = test_folder("air-state-both");
  std::filesystem::remove_all(both);
  std::filesystem::copy(after, both, std::filesystem::copy_options::recursive);
  for (const char* camera : {"sky", "scene"}) {
    std::filesystem::remove_all(both / camera);
    auto writer = FixtureWriter::create(both / camera).value();
    const bool clear_too = camera == std::string("sky") ? scene.sky_frames : scene.landmarks > 0;
    if (clear_too) append_frames(writer, before / camera, Duration{0});
    append_frames(writer, after / camera, kLater);
  }
  keep_quiet_about_the_air(both, true);
  return both;
}

TEST(AirTruthState, AnHourAfterTheSunWentTheErrorIsWhatSigmaSays) {
  const std::vector<CloudsCome> all{{"T 4", 4.0, 1}, {"T 8", 8.0, 1}, {"T 2.4", 2.4, 5}, {"T 6", 6.0, 9}};
  std::string table =
      "| closed sky, no landmarks, an hour after the clear sky | building's error, of 255 | with the air given | one "
      "sigma of the state | AOD: true | found | said |\n|---|---|---|---|---|---|---|\n";
  for (const CloudsCome& scene : figure_cases("clouds", {all[1]}, all)) {
    const auto fixture = clouds_come(scene);
    const auto out = test_folder("air-state-out");
    const auto summary = played(fixture, out);
    ASSERT_TRUE(summary.last && summary.last->air);
    const TrackedAir& state = *summary.last->air;
    const double error = building_error(fixture, out, scene.name);
    const Aerosol truth = aerosol_of(scene.turbidity), found = state.air.aerosol();
    const double sigma = aod_sigma_of(state), one_sigma = one_sigma_of(fixture, out, state);
    const double given = error_when_given(fixture, truth, scene.name);
    table += fmt::format("| {} | {:.2f} | {:.2f} | {:.2f} | {:.3f} | {:.3f} +- {:.3f} | {} |\n", scene.name, error,
                         given, one_sigma, truth.aod_550, found.aod_550, sigma, state.text());
    figure_row("found-building",
               {scene.name + ", closed sky, no landmarks, an hour after a clear one", figure_text(error, 1),
                figure_text(given + 2.0 * one_sigma, 1) + ": what sigma says", "`test_air_truth_state`"});
    EXPECT_LE(error, given + 2.0 * one_sigma) << scene.name;
    EXPECT_LE(std::abs(found.aod_550 - truth.aod_550), 2.0 * sigma) << scene.name;
    EXPECT_GE(state.age, minutes(55)) << "told";
    EXPECT_NE(state.text().find("min ago"), std::string::npos) << state.text();
  }
  fmt::print("{}", table);
}

TEST(AirTruthState, LandmarksThatWereSeenUnderAClearSkyCarryItOn) {
  const std::vector<CloudsCome> all{
      {"T 4", 4.0, 1, true, 3}, {"T 8", 8.0, 1, true, 3}, {"T 2.4", 2.4, 5, true, 3}, {"T 6", 6.0, 9, true, 3}};
  std::string table =
      "| closed sky, three landmarks, an hour after the clear sky | building's error, of 255 | with the air given | "
      "one sigma of the air | goal | AOD: true | found |\n|---|---|---|---|---|---|---|\n";
  for (const CloudsCome& scene : figure_cases("clouds before landmarks", {all[0]}, all)) {
    const auto fixture = clouds_come(scene);
    const auto out = test_folder("air-state-out");
    const auto summary = played_to_the_last(fixture, out);
    ASSERT_TRUE(summary.last && summary.last->air);
    const TrackedAir& state = *summary.last->air;
    const Aerosol truth = aerosol_of(scene.turbidity);
    const double error = building_error(fixture, out, scene.name), goal = scene.turbidity > 4.0 ? 5.0 : 3.0;
    const double given = error_when_given(fixture, truth, scene.name), one_sigma = one_sigma_of(fixture, out, state);
    // In the thinnest haze the goal is out of reach: edges and noise alone leave nearly all of it when the air is given,
    // and the landmarks' contrasts, which are not known better than to .05, leave as much again for one sigma of the
    // air. There the error is held to what these two say.
    const bool out_of_reach = scene.turbidity < 3.0;
    const double held = out_of_reach ? given + one_sigma : goal;
    table += fmt::format("| {} | {:.2f} | {:.2f} | {:.2f} | {} | {:.3f} | {:.3f} +- {:.3f}, {} |\n", scene.name, error,
                         given, one_sigma, goal, truth.aod_550, state.air.aerosol().aod_550, aod_sigma_of(state),
                         state.text());
    figure_row("found-building",
               {scene.name + ", closed sky, three landmarks, an hour after a clear one", figure_text(error, 1),
                fmt::format("{}{}", goal, out_of_reach ? "; held to " + figure_text(held, 1) : std::string()),
                "`test_air_truth_state`"});
    EXPECT_LE(error, held) << scene.name;
  }
  fmt::print("{}", table);
}

TEST(AirTruthState, WhereTheSkyWasNeverClearTheAirIsSupposedAndSaidToBe) {
  const auto fixture = clouds_come({"never clear", 4.0, 1, false});
  const auto out = test_folder("air-state-out");
  const auto summary = played(fixture, out);
  ASSERT_TRUE(summary.last && summary.last->air);
  EXPECT_TRUE(summary.last->air->supposed);
  EXPECT_FALSE(summary.last->seen_air());
  const double error = building_error(fixture, out, "never clear, T 4");
  figure_row("found-building", {"T 4, closed sky, no landmarks, never clear: air supposed", figure_text(error, 1),
                                "none: status, JSON and doctor say that it is supposed", "`test_air_truth_state`"});
  fmt::print("closed sky, never clear, T 4: {:.2f} of 255 off; {}\n", error, summary.last->air->text());
}

}  // namespace
}  // namespace kasumi
