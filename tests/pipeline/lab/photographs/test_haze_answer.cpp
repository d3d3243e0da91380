// kasumi estimate --haze, asked of land in haze in closed form.
#include <cmath>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "base/outside/json_text.hpp"
#include "pipeline/lab/photographs/haze_answer.hpp"
#include "pipeline/site/files/photograph_file.hpp"
#include "tests/environment.hpp"
#include "tests/estimator/photograph/hazy_land.hpp"
#include "tests/pipeline/run_kasumi.hpp"

namespace kasumi {
namespace {

std::string written(const HazyLand& land, const std::string& name) {
  const auto file = test_folder("haze-answer") / name;
  std::filesystem::create_directories(file.parent_path());
  EXPECT_TRUE(write_photograph(file, drawn(land)));
  return file.string();
}

TEST(HazeAnswer, SaysColourDepthAndExtinctionOfThePicture) {
  const HazyLand smog{.exponent = 0.0, .green_per_km = 0.9};
  const auto picture = written(smog, "smog.png");
  const double distance_m = distance_of_row(smog, 250);
  const auto outcome =
      run_kasumi(fmt::format("estimate --haze {} --part 100,245,300,10 --distance-m {} --json", picture, distance_m));
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = parse_json(outcome.out);
  EXPECT_TRUE(json["told"].get<bool>()) << json["reason"];
  EXPECT_NEAR(json["angstrom_exponent"].get<double>(), 0.0, 0.3);
  const double sigma_per_m = json["sigma_per_m"];
  EXPECT_NEAR(json["extinction_per_m"].get<double>(), 0.9e-3, 2.0 * sigma_per_m);
  EXPECT_LT(sigma_per_m, 0.7e-3) << "no sky is beside it";
  EXPECT_EQ(json["visibility"], "value");
  // Of 1200 m of the same aerosol, without the molecules' share.
  EXPECT_NEAR(json["aod_550"].get<double>(), (json["extinction_per_m"].get<double>() - 1.2e-5) * 1200.0, 0.005);
  const auto text = run_kasumi(fmt::format("estimate --haze {}", picture));
  EXPECT_THAT(text.out, testing::HasSubstr("colour of the haze   exponent"));
}

TEST(HazeAnswer, OfClearAirIsABoundAndNoGuess) {
  const HazyLand clear{.exponent = 1.3, .green_per_km = 0.02};
  const auto answers = hazes_of({written(clear, "clear.png")}, {HazyPart{100, 300, 300, 20}, 600.0, 0.0});
  ASSERT_EQ(answers.size(), 1U);
  const auto& answer = answers.front();
  ASSERT_TRUE(answer) << answer.error().message;
  EXPECT_FALSE(answer->colour.told);
  EXPECT_EQ(answer->exponent, 1.3) << "what is usual";
  EXPECT_TRUE(answer->clear());
  EXPECT_THAT(haze_text(*answer), testing::HasSubstr("visibility at least"));
  const auto outcome = run_kasumi(fmt::format("estimate --haze {}", written(clear, "clear.png")));
  EXPECT_EQ(outcome.code, 1) << "nothing tells the air";
}

}  // namespace
}  // namespace kasumi
