// The whole way, from a recording of known truth to the picture.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

#include "base/files.hpp"
#include "pipeline/photograph.hpp"
#include "pipeline/replay.hpp"
#include "tests/pipeline/recorded.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using Row = std::map<std::string, std::string>;

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      fields.emplace_back();
    else
      fields.back() += c;
  }
  return fields;
}

std::vector<Row> read_csv(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::vector<Row> rows;
  std::vector<std::string> names;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    const auto fields = fields_of(line);
    if (names.empty()) {
      names = fields;
      continue;
    }
    Row row;
    for (std::size_t i = 0; i < names.size() && i < fields.size(); ++i) row[names[i]] = fields[i];
    rows.push_back(row);
  }
  return rows;
}

ReplaySummary played(const std::filesystem::path& fixture, const std::filesystem::path& out, SceneAirOptions air = {}) {
  const auto summary = replay({fixture, out, false, false, std::nullopt, air});
  if (!summary) {
    ADD_FAILURE() << summary.error().message;
    return {};
  }
  return *summary;
}

// Sky frames and truth are listed by time; each estimate is compared with the truth of its instant.
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

TEST(Replay, TurbidityOfClearFixturesIsFoundWithinATenth) {
  for (const char* preset : {"clear-noon", "sun-low"}) {
    SCOPED_TRACE(preset);
    const auto fixture = recorded(small(preset, 3), std::string("truth-") + preset);
    const auto out = test_folder(std::string("truth-out-") + preset);
    const auto summary = played(fixture, out);
    EXPECT_EQ(summary.pictures, 3u);
    expect_turbidity(fixture, out, 0.1);
  }
}

TEST(Replay, ARisingTurbidityIsFollowed) {
  auto recipe = small("turbidity-change", 6);
  const auto fixture = recorded(recipe, "change");
  const auto out = test_folder("change-out");
  played(fixture, out);
  expect_turbidity(fixture, out, 0.1);
}

// Where two outputs that should be the same begin to differ, in words.
std::string what_differs(const std::filesystem::path& a, const std::filesystem::path& b) {
  if (a.extension() != ".png") {
    std::ifstream one(a), other(b);
    std::string line, other_line;
    for (int number = 1; std::getline(one, line) && std::getline(other, other_line); ++number)
      if (line != other_line)
        return fmt::format("{} line {}:\n{}\n{}", a.filename().string(), number, line, other_line);
    return fmt::format("{}: one has more lines", a.filename().string());
  }
  const auto one = read_photograph(a).value().encoded, other = read_photograph(b).value().encoded;
  if (one.width() != other.width() || one.height() != other.height())
    return fmt::format("{}: {} x {} and {} x {}", a.filename().string(), one.width(), one.height(), other.width(),
                       other.height());
  int pixels = 0, left = one.width(), right = -1, top = one.height(), bottom = -1;
  double largest = 0.0;
  for (int y = 0; y < one.height(); ++y)
    for (int x = 0; x < one.width(); ++x) {
      const auto difference = 255.0 * glm::abs(glm::dvec3(one.at(x, y)) - glm::dvec3(other.at(x, y)));
      if (const double worst = std::max({difference.r, difference.g, difference.b}); worst > 0.0) {
        ++pixels, largest = std::max(largest, worst);
        left = std::min(left, x), right = std::max(right, x), top = std::min(top, y), bottom = std::max(bottom, y);
      }
    }
  return fmt::format("{}: {} pixels differ, by {:.1f}/255 at most, in columns {} to {}, rows {} to {}",
                     a.filename().string(), pixels, largest, left, right, top, bottom);
}

TEST(Replay, TheSameFixtureGivesTheSamePicturesBitForBit) {
  const auto fixture = recorded(small("broken-clouds", 3), "same");
  const auto first = test_folder("same-1"), second = test_folder("same-2");
  played(fixture, first);
  played(fixture, second);
  for (const char* name : {"frame-000000.png", "frame-000002.png", "turbidity.csv"}) {
    const auto a = read_file(first / name), b = read_file(second / name);
    ASSERT_TRUE(a && b) << name;
    // Not EXPECT_EQ: a picture's bytes tell a reader nothing.
    EXPECT_TRUE(*a == *b) << what_differs(first / name, second / name);
  }
}

// Mean error of the building's pixels, in levels of 255, against the picture that the slow spectral path draws of the
// same scene.
double building_error(const std::filesystem::path& fixture, const std::filesystem::path& out, const char* name) {
  const auto picture = read_photograph(out / "frame-000000.png").value();
  const auto truth = read_photograph(fixture / "truth" / "composite-000000.png").value();
  const auto coverage = read_photograph(fixture / "truth" / "coverage-000000.png").value();
  double error = 0.0, weight = 0.0;
  glm::dvec3 bias{};
  for (int y = 0; y < truth.encoded.height(); ++y)
    for (int x = 0; x < truth.encoded.width(); ++x) {
      const double covered = coverage.encoded.at(x, y).r;
      if (covered <= 0.0) continue;
      const auto difference = 255.0 * (glm::dvec3(picture.encoded.at(x, y)) - glm::dvec3(truth.encoded.at(x, y)));
      error += covered * (std::abs(difference.r) + std::abs(difference.g) + std::abs(difference.b)) / 3.0;
      bias += covered * difference;
      weight += covered;
    }
  EXPECT_GT(weight, 500.0) << "the building must be seen";
  bias /= weight;
  std::printf("%s: mean error over the building %.2f/255, bias R %.2f G %.2f B %.2f, %.0f pixels\n", name,
              error / weight, bias.r, bias.g, bias.b, weight);
  return error / weight;
}

TEST(Replay, TheBuildingsPixelsComeWithinTwoLevelsOfTheSpectralReference) {
  for (const char* preset : {"clear-noon", "hazy-afternoon", "broken-clouds"}) {
    SCOPED_TRACE(preset);
    auto recipe = fixtures::recipe_of(preset).value();
    recipe.sky_frames = recipe.scene_frames = 2;
    recipe.truth_frames = 1;
    const auto fixture = recorded(recipe, std::string("composite-") + preset);
    const auto out = test_folder(std::string("composite-out-") + preset);
    played(fixture, out);
    EXPECT_LE(building_error(fixture, out, preset), 2.0);
  }
}

TEST(Replay, InTheDemoThinCloudsAtTheHorizonDoNotColourTheBuilding) {
  const std::filesystem::path fixture = source_folder() / "fixtures" / "demo";
  const auto out = test_folder("composite-out-demo");
  ASSERT_TRUE(replay({fixture, out, false, false, 1, {}}));
  EXPECT_LE(building_error(fixture, out, "demo"), 2.0);
}

TEST(Replay, WithoutUsableSkyThePictureIsStillDrawn) {
  const auto fixture = recorded(small("overcast", 2), "overcast");
  const auto summary = played(fixture, test_folder("overcast-out"));
  EXPECT_EQ(summary.pictures, 2u);
  EXPECT_EQ(summary.usable_sky_frames, 0u);
  ASSERT_TRUE(summary.last);
  EXPECT_EQ(summary.last->estimate.sky, SkyCondition::overcast) << summary.last->estimate.reason;
}

TEST(Replay, ACoveredLensIsToldFromBadWeather) {
  const auto fixture = recorded(small("covered-lens", 2), "covered");
  const auto summary = played(fixture, test_folder("covered-out"));
  EXPECT_EQ(summary.usable_sky_frames, 0u);
  ASSERT_TRUE(summary.last);
  EXPECT_EQ(summary.last->estimate.sky, SkyCondition::covered_lens) << summary.last->estimate.reason;
}

TEST(Replay, EveryFaultOfTheFormatIsSkippedAndCounted) {
  auto recipe = small("clear-noon", 12);
  recipe.faults = true;
  const auto fixture = recorded(recipe, "faults");
  const auto summary = played(fixture, test_folder("faults-out"));
  EXPECT_GT(summary.pictures, 3u);
  EXPECT_FALSE(summary.skipped.empty());
}

TEST(Replay, NoMorePicturesThanAskedFor) {
  const auto fixture = recorded(small("clear-noon", 3), "two");
  const auto summary = replay({fixture, test_folder("two-out"), false, false, 2, {}});
  ASSERT_TRUE(summary) << summary.error().message;
  EXPECT_EQ(summary->pictures, 2u);
}

TEST(Replay, AFixtureThatIsNotThereIsNamed) {
  const auto summary = replay({"/nowhere/fixture", std::nullopt, false, false, std::nullopt, {}});
  ASSERT_FALSE(summary);
  EXPECT_EQ(summary.error().kind, FaultKind::bad_input);
  EXPECT_THAT(summary.error().message, testing::HasSubstr("/nowhere/fixture"));
}

TEST(Replay, EveryProblemOfADescriptionIsToldAtOnce) {
  const auto fixture = recorded(small("clear-noon", 1), "broken-toml");
  auto text = read_text_file(fixture / "fixture.toml").value();
  const auto put = [&](const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
  };
  put("latitude_deg = ", "latitude_deg = 1000 #");
  put("model = \"temple.glb\"", "model = \"castle-that-is-not-there.glb\"");
  put("[scene]\n", "[scene]\nwidht = 3\n");
  ASSERT_TRUE(write_text_file(fixture / "fixture.toml", text));
  const auto summary = replay({fixture, std::nullopt, false, false, std::nullopt, {}});
  ASSERT_FALSE(summary);
  for (const char* word : {"site.latitude_deg = 1000", "castle-that-is-not-there.glb", "scene.widht"})
    EXPECT_THAT(summary.error().message, testing::HasSubstr(word));
}

TEST(Replay, ADamagedModelIsAMessage) {
  const auto fixture = recorded(small("clear-noon", 1), "broken-model");
  auto bytes = read_file(fixture / "temple.glb").value();
  bytes.resize(bytes.size() / 2);
  ASSERT_TRUE(write_file(fixture / "temple.glb", bytes));
  const auto summary = replay({fixture, std::nullopt, false, false, std::nullopt, {}});
  ASSERT_FALSE(summary);
  EXPECT_EQ(summary.error().kind, FaultKind::bad_input);
  EXPECT_THAT(summary.error().message, testing::HasSubstr("temple.glb"));
}

}  // namespace
}  // namespace kasumi
