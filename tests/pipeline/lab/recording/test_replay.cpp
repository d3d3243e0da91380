// End to end, from a recording of known truth to the picture.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <sstream>

#include "base/files.hpp"
#include "pipeline/lab/recording/replay.hpp"
#include "pipeline/site/files/photograph_file.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/recorded.hpp"
#include "tests/pipeline/replayed.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

// Describes where two outputs that should be equal begin to differ.
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
    // Not EXPECT_EQ: a dump of a picture's bytes would be useless.
    EXPECT_TRUE(*a == *b) << what_differs(first / name, second / name);
  }
}

ReplaySummary played_under(const GivenAir& given, const std::filesystem::path& fixture,
                           const std::filesystem::path& out) {
  ReplayRequest request;
  request.fixture = fixture;
  request.out = out;
  request.given = given;
  const auto summary = replay(request);
  if (!summary) ADD_FAILURE() << summary.error().message;
  return summary ? *summary : ReplaySummary{};
}

TEST(Replay, AGivenAirDrivesThePictureWhateverTheSkySays) {
  const auto fixture = recorded(small("papers-noon", 2), "given-air");
  const auto by_option = test_folder("given-air-option"), by_key = test_folder("given-air-key"),
             usual = test_folder("given-air-usual");
  const GivenAir smoke{0.5, 1.6, AerosolKind::smoke};
  played(fixture, usual);
  const auto summary = played_under(smoke, fixture, by_option);
  EXPECT_EQ(summary.given, smoke.whole());
  ASSERT_TRUE(summary.last && summary.air && summary.last->seen_air());
  EXPECT_EQ(summary.air->aerosol, smoke.whole());
  EXPECT_NEAR(summary.last->seen_air()->air.turbidity().value, turbidity_of(*smoke.whole()), 1e-9);
  EXPECT_TRUE(summary.last->seen_air()->trustworthy);

  // In the place of what the fixture itself says of its air.
  std::istringstream lines(read_text_file(fixture / "fixture.toml").value());
  std::string text;
  for (std::string line; std::getline(lines, line);) {
    const bool of_air = line.starts_with("aod_550") || line.starts_with("angstrom") || line.starts_with("aerosol");
    if (!of_air) text += line + "\n";
    if (line == "[site]") text += "aod_550 = 0.5\nangstrom_exponent = 1.6\naerosol = \"smoke\"\n";
  }
  ASSERT_TRUE(write_text_file(fixture / "fixture.toml", text));
  EXPECT_EQ(played(fixture, by_key).given, smoke.whole());
  const auto picture = [](const std::filesystem::path& folder) {
    return read_file(folder / "frame-000000.png").value();
  };
  EXPECT_TRUE(picture(by_option) == picture(by_key))
      << what_differs(by_option / "frame-000000.png", by_key / "frame-000000.png");
  EXPECT_FALSE(picture(by_option) == picture(usual)) << "smoke dims and reddens";
}

TEST(Replay, OfAGivenKindTheAmountIsFoundInTheSky) {
  const auto fixture = recorded(small("clear-noon", 2), "given-kind");
  const auto summary =
      played_under({std::nullopt, std::nullopt, AerosolKind::continental}, fixture, test_folder("given-kind-out"));
  EXPECT_FALSE(summary.given);
  ASSERT_TRUE(summary.air);
  ASSERT_TRUE(summary.air->aerosol);
  EXPECT_EQ(summary.air->aerosol->kind, AerosolKind::continental);
  EXPECT_GT(summary.air->aerosol->aod_550, 0.0);
}

TEST(Replay, ByThePapersSkyTAloneIsFollowed) {
  const auto fixture = recorded(small("papers-noon", 2), "papers-way");
  auto text = read_text_file(fixture / "fixture.toml").value();
  text.replace(text.find("[site]"), 6, "[site]\nsky_model = \"preetham\"");
  ASSERT_TRUE(write_text_file(fixture / "fixture.toml", text));
  const auto summary = played(fixture, test_folder("papers-way-out"));
  ASSERT_TRUE(summary.last && summary.last->seen_air());
  const TrackedAir& air = *summary.last->air;
  EXPECT_FALSE(air.air.aerosol_known());
  EXPECT_NEAR(air.believed.turbidity().value, summary.last->estimate.turbidity.value, 0.05);
  ASSERT_EQ(air.observers.size(), 1U) << "landmarks change nothing";
  EXPECT_EQ(air.observers.front().by, AirObserver::sky);
}

// Neither the building nor, for edges may be a pixel wide, next to it.
bool is_beside(const Image<glm::vec3>& coverage, int x, int y) {
  for (int v = y - 1; v <= y + 1; ++v)
    for (int u = x - 1; u <= x + 1; ++u)
      if (coverage.contains(u, v) && coverage.at(u, v).r > 0.0F) return false;
  return true;
}

// M Fig 11: airlight and direct transmission. What comes through is the building without air, attenuated alike all over
// it, and what is scattered in is the complement of that.
TEST(Replay, ItsTermsAddUpToThePictureInLinearLight) {
  auto recipe = small("clear-noon", 1);
  recipe.truth_frames = 1;
  const auto fixture = recorded(recipe, "terms");
  const auto out = test_folder("terms-out"), without_air = test_folder("terms-without-air");
  ReplayRequest request;
  request.fixture = fixture;
  request.out = out;
  request.terms = true;
  const auto summary = must(replay(request));
  request.out = without_air;
  request.terms = false;
  request.air.aerial_perspective = false;
  ASSERT_TRUE(replay(request));
  const auto read = [](const std::filesystem::path& path) { return read_photograph(path).value().encoded; };
  const auto whole = read(out / "frame-000000.png"), airlight = read(out / "frame-000000.airlight.png"),
             direct = read(out / "frame-000000.direct.png"), bare = read(without_air / "frame-000000.png"),
             coverage = read(fixture / "truth" / "coverage-000000.png");
  const auto srgb = Response::srgb();
  const auto light = [&](const Image<glm::vec3>& of, std::size_t i) {
    return srgb.to_light(glm::dvec3(of.elements()[i]));
  };
  double largest = 0.0;
  std::vector<double> passed, scattered;  // green, where the building is bright enough to tell
  for (std::size_t i = 0; i < whole.elements().size(); ++i) {
    const auto a = light(airlight, i), d = light(direct, i);
    const auto off = glm::abs(srgb.to_encoded(a + d) - glm::dvec3(whole.elements()[i])) * 255.0;
    largest = std::max({largest, off.r, off.g, off.b});
    const int x = static_cast<int>(i) % whole.width(), y = static_cast<int>(i) / whole.width();
    if (is_beside(coverage, x, y)) {
      EXPECT_LE(a.g, 1e-3) << "the camera's own picture is not taken apart";
    }
    const auto without = light(bare, i);
    if (coverage.elements()[i].r < 1.0F || without.g < 0.1 || without.g > 0.8) continue;
    passed.push_back(d.g / without.g);
    scattered.push_back(a.g);
  }
  EXPECT_LE(largest, 0.05) << "of a step of 255";
  ASSERT_GE(passed.size(), 100u);
  const auto spread = [](std::vector<double> values) {
    std::ranges::sort(values);
    const auto n = values.size();
    return std::array{values[n / 2], values[9 * n / 10] - values[n / 10]};
  };
  const auto [gamma, gamma_spread] = spread(passed);
  const auto [mean_airlight, airlight_spread] = spread(scattered);
  fmt::print("green: {:.3f} passes (spread {:.3f}), airlight {:.3f} (spread {:.3f}), from infinity {:.3f}\n", gamma,
             gamma_spread, mean_airlight, airlight_spread, mean_airlight / (1.0 - gamma));
  EXPECT_GT(gamma, 0.3);
  EXPECT_LT(gamma, 0.95);
  EXPECT_LE(gamma_spread, 0.08 * gamma) << "of a building some kilometres away all is attenuated alike";
  EXPECT_LE(airlight_spread, 0.1 * mean_airlight) << "whatever its colours";

  request.out = out / "film.mp4";
  request.terms = true;
  EXPECT_THAT(replay(request), FailsWith(testing::HasSubstr("--terms: expected --out FOLDER")));
}

TEST(Replay, WithoutUsableSkyThePictureIsStillDrawn) {
  const auto fixture = recorded(small_scene("overcast", 2), "overcast");
  const auto summary = played(fixture, test_folder("overcast-out"));
  EXPECT_EQ(summary.pictures, 2u);
  EXPECT_EQ(summary.usable_sky_frames, 0u);
  ASSERT_TRUE(summary.last);
  EXPECT_THAT(summary.last->estimate.sky, testing::AnyOf(SkyCondition::overcast, SkyCondition::unknown))
      << summary.last->estimate.reason;
}

TEST(Replay, ACoveredLensIsDistinguishedFromBadWeather) {
  const auto fixture = recorded(small_scene("covered-lens", 2), "covered");
  const auto summary = played(fixture, test_folder("covered-out"));
  EXPECT_EQ(summary.usable_sky_frames, 0u);
  ASSERT_TRUE(summary.last);
  EXPECT_EQ(summary.last->estimate.sky, SkyCondition::covered_lens) << summary.last->estimate.reason;
}

TEST(Replay, EveryFaultOfTheFormatIsSkippedAndCounted) {
  auto recipe = small_scene("clear-noon", 12);
  recipe.sky_size = 240;
  recipe.faults = true;
  const auto fixture = recorded(recipe, "faults");
  const auto summary = played(fixture, test_folder("faults-out"));
  EXPECT_GT(summary.pictures, 3u);
  EXPECT_FALSE(summary.skipped.empty());
}

TEST(Replay, NoMorePicturesThanRequested) {
  const auto fixture = recorded(small_scene("clear-noon", 3), "two");
  const auto summary = must(replay({fixture, test_folder("two-out"), false, false, 2, {}}));
  EXPECT_EQ(summary->pictures, 2u);
  EXPECT_EQ(summary->sky_frames, 2u) << "what was read ahead is left";
}

// Each picture is written while the next one is drawn.
TEST(Replay, APictureThatCannotBeWrittenEndsItAndThoseBeforeItStay) {
  const auto fixture = recorded(small_scene("clear-noon", 4), "unwritable");
  for (const auto* last : {"frame-000001.png", "frame-000003.png"}) {
    const auto out = test_folder(fmt::format("unwritable-{}", last));
    std::filesystem::create_directories(out / last / "in the way");
    EXPECT_THAT(replay({fixture, out, false, false, std::nullopt, {}}),
                FailsAs(FaultKind::io, testing::HasSubstr((out / last).string())));
    EXPECT_TRUE(std::filesystem::is_regular_file(out / "frame-000000.png"));
    EXPECT_TRUE(std::filesystem::is_regular_file(out / "frame-000001.png") || last[11] == '1');
    EXPECT_FALSE(std::filesystem::exists(out / "turbidity.csv")) << "it would say that all is there";
  }
}

TEST(Replay, ItSaysWhereItsTimeWent) {
  const auto fixture = recorded(small_scene("clear-noon", 3), "times");
  const auto summary = must(replay({fixture, test_folder("times-out"), false, false, std::nullopt, {}}));
  for (const auto stage : {ReplayStage::decoding, ReplayStage::air, ReplayStage::layers, ReplayStage::writing}) {
    const auto i = static_cast<std::size_t>(stage);
    EXPECT_GT(summary->stages[i], 0.0) << kReplayStageNames[i];
    EXPECT_LE(summary->stages[i], 3.0 * summary->seconds) << kReplayStageNames[i] << ": of three pictures";
  }
  EXPECT_EQ(text_of(StageSeconds{0.01, 0.05, 0.1, 0.02, 0.02}, 2),
            "100.0 ms a picture: decoding 5.0 (5 %), air 25.0 (25 %), layers 50.0 (50 %), drawing 10.0 (10 %), writing "
            "10.0 (10 %)");
}

TEST(Replay, AMissingFixtureIsReported) {
  EXPECT_THAT(replay({"/nowhere/fixture", std::nullopt, false, false, std::nullopt, {}}),
              FailsAs(FaultKind::bad_input, testing::HasSubstr("/nowhere/fixture")));
}

TEST(Replay, EveryProblemOfADescriptionIsReportedAtOnce) {
  const auto fixture = recorded(small_scene("clear-noon", 1), "broken-toml");
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

TEST(Replay, ADamagedModelGivesAMessage) {
  const auto fixture = recorded(small_scene("clear-noon", 1), "broken-model");
  auto bytes = read_file(fixture / "temple.glb").value();
  bytes.resize(bytes.size() / 2);
  ASSERT_TRUE(write_file(fixture / "temple.glb", bytes));
  EXPECT_THAT(replay({fixture, std::nullopt, false, false, std::nullopt, {}}),
              FailsAs(FaultKind::bad_input, testing::HasSubstr("temple.glb")));
}

}  // namespace
}  // namespace kasumi
