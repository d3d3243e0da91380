// The command line as a user or a script uses it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "pipeline/files/picture_sink.hpp"
#include "tests/pipeline/run_kasumi.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

class EstimateCommand : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    fixtures::SkyRecipe recipe;
    recipe.turbidity = 3.0;
    recipe.size = 400;
    sky = test_folder("command") / "sky.png";
    std::filesystem::create_directories(sky.parent_path());
    ASSERT_TRUE(write_png(sky, fixtures::sky_picture(recipe).pixels));
  }
  static std::filesystem::path sky;
  const std::string camera = "--circle 199.5,199.5,200 --sun-zenith-deg 58.4 --sun-azimuth-deg 180";
};
std::filesystem::path EstimateCommand::sky;

TEST_F(EstimateCommand, JsonHasEveryDocumentedKey) {
  const auto outcome = run_kasumi("estimate --json " + camera + " " + sky.string());
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(outcome.out);
  for (const char* key :
       {"turbidity", "sigma", "usable", "reason", "sky", "clear_fraction", "samples", "sky_model", "sun_zenith_deg",
        "sun_azimuth_deg", "aod_550", "angstrom_exponent", "aerosol", "visibility_m", "weather"})
    EXPECT_TRUE(json.contains(key)) << key;
  EXPECT_TRUE(json["usable"]);
  EXPECT_NEAR(json["turbidity"].get<double>(), 3.0, 0.1);
  EXPECT_NEAR(json["sun_zenith_deg"].get<double>(), 58.4, 1e-3);
}

TEST_F(EstimateCommand, TheRequestedSkyModelIsFitted) {
  // The generated sky is Preetham's, not the dome's; only the choice of the model is under test.
  for (const auto& [options, model] : {std::pair{"", "preetham"},
                                       {"--sky-model dome", "dome"},
                                       {"--sky-model automatic --altitude-m 1400", "preetham"},
                                       {"--sky-model automatic --altitude-m 1600", "dome"}}) {
    const auto outcome = run_kasumi(fmt::format("estimate --json {} {} {}", options, camera, sky.string()));
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(nlohmann::json::parse(outcome.out)["sky_model"], model) << options;
  }
  const auto outcome = run_kasumi("estimate --sky-model dome --method reference-pixel " + camera + " " + sky.string());
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("--sky-model preetham"));
}

TEST_F(EstimateCommand, AGivenKindIsFittedByTheDome) {
  const auto outcome = run_kasumi("estimate --json --aerosol maritime " + camera + " " + sky.string());
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json["sky_model"], "dome");
  if (json["usable"]) {
    EXPECT_EQ(json["aerosol"], "maritime");
    EXPECT_NEAR(json["angstrom_exponent"].get<double>(), natural_exponent(AerosolKind::maritime), 1e-3);
  }
  const auto contradicted = run_kasumi("estimate --aerosol dust --sky-model preetham " + camera + " " + sky.string());
  EXPECT_EQ(contradicted.code, 2);
  EXPECT_THAT(contradicted.err, HasSubstr("--sky-model dome"));
  const auto unknown = run_kasumi("estimate --aerosol fog " + camera + " " + sky.string());
  EXPECT_EQ(unknown.code, 2);
  EXPECT_THAT(unknown.err, HasSubstr("continental"));
}

TEST_F(EstimateCommand, AListOnStandardInputGivesOneObjectALineInItsOrder) {
  const auto list = test_folder("command") / "list.txt";
  std::ofstream(list) << sky.string() << "\n" << sky.string() << "\n" << sky.string() << "\n";
  const auto outcome = run_kasumi("estimate --json " + camera + " - <" + list.string());
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  std::istringstream lines(outcome.out);
  int count = 0;
  std::string first;
  for (std::string line; std::getline(lines, line); ++count) {
    if (count == 0) first = line;
    EXPECT_EQ(line, first);
  }
  EXPECT_EQ(count, 3);
}

TEST_F(EstimateCommand, AnUnreadableImageIsReportedAndTheOthersAreProcessed) {
  const auto broken = test_folder("command") / "broken.png";
  std::ofstream(broken) << "no picture";
  const auto outcome = run_kasumi("estimate --json " + camera + " " + broken.string() + " " + sky.string());
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("broken.png"));
  EXPECT_THAT(outcome.out, HasSubstr("\"usable\":true"));
}

TEST_F(EstimateCommand, AnUnusableSkyIsNoError) {
  const auto black = test_folder("command") / "black.png";
  ASSERT_TRUE(write_png(black, Image<Rgb8>(400, 400)));
  const auto outcome = run_kasumi("estimate --json " + camera + " " + black.string());
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_FALSE(json["usable"]);
  EXPECT_FALSE(json["reason"].get<std::string>().empty());
  EXPECT_TRUE(json["turbidity"].is_null());
}

TEST_F(EstimateCommand, EveryWrongOptionIsReportedAtOnce) {
  const auto outcome = run_kasumi("estimate --sun-zenith-deg 10 --lat 40 --utc yesterday " + sky.string());
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("--sun-azimuth-deg"));
  EXPECT_THAT(outcome.err, HasSubstr("--lon"));
  EXPECT_THAT(outcome.err, HasSubstr("--utc yesterday"));
}

TEST_F(EstimateCommand, APlotIsWrittenNextToTheImageOnRequest) {
  const auto plot = sky.string() + ".fit.png";
  std::filesystem::remove(plot);
  ASSERT_EQ(run_kasumi("estimate --plot " + camera + " " + sky.string()).code, 0);
  EXPECT_GT(std::filesystem::file_size(plot), 1000u);
}

TEST(CommandLine, AnUnknownCommandIsBadInput) {
  EXPECT_EQ(run_kasumi("conjure").code, 2);
  EXPECT_EQ(run_kasumi("").code, 2);
  EXPECT_EQ(run_kasumi("--help").code, 0);
  EXPECT_EQ(run_kasumi("--version").code, 0);
}

TEST(CommandLine, AMissingFixtureIsBadInput) {
  const auto outcome = run_kasumi("replay /nowhere/at-all");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("/nowhere/at-all"));
}

}  // namespace
}  // namespace kasumi
