// The recording in real time, with the sky in a thread of its own.
#include <gtest/gtest.h>

#include <sstream>

#include <glm/common.hpp>

#include "base/files.hpp"
#include "pipeline/lab/recording/replay.hpp"
#include "pipeline/site/files/photograph_file.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {
namespace {

std::vector<std::string> split_lines(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST(Replay, InRealTimeTheSkyRunsInParallelWithTheScene) {
  auto recipe = small_scene("clear-noon", 3);
  recipe.sky_period_s = recipe.scene_period_s = 0.2;
  const auto fixture = recorded(recipe, "realtime");
  const auto summary = replay({fixture, test_folder("realtime-out"), false, true, std::nullopt, {}});
  ASSERT_TRUE(summary) << summary.error().message;
  EXPECT_EQ(summary->pictures, 3u);
  // Where the machine is slow the sky falls behind, and the scene does not wait for it.
  EXPECT_GE(summary->sky_frames, 1u);
  EXPECT_LE(summary->sky_frames, 3u);
}

// Mean difference of two pictures, in levels of 255.
double difference(const std::filesystem::path& a, const std::filesystem::path& b) {
  const auto one = read_photograph(a).value(), other = read_photograph(b).value();
  double sum = 0.0;
  for (std::size_t i = 0; i < one.encoded.elements().size(); ++i) {
    const auto d = glm::abs(glm::dvec3(one.encoded.elements()[i]) - glm::dvec3(other.encoded.elements()[i]));
    sum += 255.0 / 3.0 * (d.r + d.g + d.b);
  }
  return sum / static_cast<double>(one.encoded.elements().size());
}

// The sky camera's only picture comes after two of the scene. The building in these stands under the sun of their own
// time, as in a replay in which the sky came first, whatever the pace.
TEST(Replay, BeforeTheSkyIsSeenTheSunIsWhereTheTimeSays) {
  auto recipe = small_scene("clear-noon", 3);
  recipe.sky_period_s = recipe.scene_period_s = 0.2;
  const auto early = recorded(recipe, "sky-first"), late = recorded(recipe, "sky-last");
  const auto index = late / "sky" / "index.csv";
  const auto lines = split_lines(read_text_file(index).value());
  ASSERT_TRUE(write_text_file(index, lines.front() + "\n" + lines.back() + "\n"));

  ReplayRequest request{early, test_folder("sky-first-out"), false, false, std::nullopt, {}};
  request.air.turbidity = Turbidity{2.5};  // so that nothing but the sun is to be known
  ASSERT_TRUE(replay(request));
  for (const bool realtime : {false, true}) {
    ReplayRequest later = request;
    later.fixture = late;
    later.out = test_folder(realtime ? "sky-last-realtime" : "sky-last-out");
    later.realtime = realtime;
    const auto summary = replay(later);
    ASSERT_TRUE(summary) << summary.error().message;
    const double apart = difference(*request.out / "frame-000000.png", *later.out / "frame-000000.png");
    EXPECT_LT(apart, 0.05) << (realtime ? "in real time" : "as fast as possible");
  }
}

}  // namespace
}  // namespace kasumi
