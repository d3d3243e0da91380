// The command line as a user or a script uses it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/outside/json_text.hpp"
#include "pipeline/site/files/picture_sink.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/run_kasumi.hpp"

namespace kasumi {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class EstimateCommand : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    fixtures::FisheyeRecipe recipe;
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
  const auto outcome = ended(0, run_kasumi("estimate --json " + camera + " " + sky.string()));
  const auto json = parse_json(outcome.out);
  for (const char* key : {"turbidity", "sigma", "usable", "reason", "sky", "clear_fraction", "samples", "sky_model",
                          "sun_zenith_deg", "sun_azimuth_deg", "aod_550", "sigma_aod_550", "angstrom_exponent",
                          "sigma_angstrom", "aerosol", "models", "visibility_m", "weather"})
    EXPECT_TRUE(json.contains(key)) << key;
  EXPECT_TRUE(json["usable"]);
  EXPECT_NEAR(json["turbidity"].get<double>(), 3.0, 0.2);  // by a camera of unknown tone curve
  EXPECT_NEAR(json["sun_zenith_deg"].get<double>(), 58.4, 1e-3);
}

TEST_F(EstimateCommand, TheRequestedSkyModelIsFitted) {
  // The generated sky is Preetham's, not the dome's: where all models are asked, his explains it.
  for (const auto& [options, model] : {std::pair{"", "preetham"},
                                       {"--sky-model preetham", "preetham"},
                                       {"--sky-model dome", "dome"},
                                       {"--sky-model auto", "preetham"},
                                       {"--sky-model automatic --altitude-m 1600", "preetham"}}) {
    const auto outcome = run_kasumi(fmt::format("estimate --json {} {} {}", options, camera, sky.string()));
    ASSERT_LE(outcome.code, 1) << outcome.err;  // the dome may say that this is no sky of its own
    EXPECT_EQ(parse_json(outcome.out)["sky_model"], model) << options;
  }
  EXPECT_THAT(
      ended(2, run_kasumi("estimate --sky-model dome --method reference-pixel " + camera + " " + sky.string())).err,
      HasSubstr("--sky-model preetham"));
}

TEST_F(EstimateCommand, AGivenKindIsFittedByTheDome) {
  const auto outcome = run_kasumi("estimate --json --sky-model dome --aerosol maritime " + camera + " " + sky.string());
  ASSERT_LE(outcome.code, 1) << outcome.err;
  const auto json = parse_json(outcome.out);
  EXPECT_EQ(json["sky_model"], "dome");
  if (json["usable"]) {
    EXPECT_EQ(json["aerosol"], "maritime");
    EXPECT_NEAR(json["angstrom_exponent"].get<double>(), natural_exponent(AerosolKind::maritime), 1e-3);
  }
  EXPECT_THAT(ended(2, run_kasumi("estimate --aerosol dust --sky-model preetham " + camera + " " + sky.string())).err,
              HasSubstr("--sky-model dome"));
  EXPECT_THAT(ended(2, run_kasumi("estimate --aerosol fog " + camera + " " + sky.string())).err,
              HasSubstr("continental"));
}

TEST_F(EstimateCommand, HosekAndWilkiesSkyIsAskedAloneOrBesideTheOthers) {
  const auto data = shared_data_folder() / "sky" / "hosek" / "sunsky_datasets.bin";
  if (!std::filesystem::exists(data)) GTEST_SKIP() << data << " is not here";
  const auto of = [&](const std::string& model) {
    const auto outcome = run_kasumi(fmt::format("estimate --json --sky-model {}{} --plot-dir {} {} {}", model,
                                                data.string(), sky.parent_path().string(), camera, sky.string()));
    EXPECT_LE(outcome.code, 1) << outcome.err;
    return parse_json(outcome.out);
  };
  const auto alone = of("hosek:");
  EXPECT_EQ(alone["sky_model"], "hosek");
  EXPECT_TRUE(alone["aerosol"].is_null()) << "his sky knows no kinds";
  const auto beside = of("auto+hosek:");
  const auto names = [&] {
    std::vector<std::string> all;
    for (const auto& model : beside["models"]) all.push_back(model["name"]);
    return all;
  }();
  EXPECT_THAT(names, ::testing::IsSupersetOf({"preetham", "hosek", "dome, continental"}));
  double sum = 0.0;
  for (const auto& model : beside["models"]) sum += model["weight"].get<double>();
  EXPECT_NEAR(sum, 1.0, 1e-3);
}

TEST_F(EstimateCommand, AnUnknownSkyModelIsRefused) {
  for (const std::string model : {"perez", "hosek", "preetham+hosek:x", "hosek:/nowhere.bin"}) {
    const auto outcome = run_kasumi("estimate --sky-model " + model + " " + camera + " " + sky.string());
    EXPECT_EQ(outcome.code, 2) << model;
    EXPECT_THAT(outcome.err, HasSubstr("--sky-model")) << model;
  }
}

// The papers' method and sky give what they always gave; the other keys may grow.
TEST_F(EstimateCommand, ThePapersWayKeepsToThePapersSky) {
  const auto of = [&](const std::string& options) {
    const auto outcome = ended(0, run_kasumi("estimate --json " + options + " " + camera + " " + sky.string()));
    return parse_json(outcome.out);
  };
  const auto papers = of("--method reference-pixel"), same = of("--method reference-pixel --sky-model preetham");
  EXPECT_EQ(papers, same);
  EXPECT_EQ(papers["sky_model"], "preetham");
  EXPECT_TRUE(papers["models"].empty());
  EXPECT_TRUE(papers["aerosol"].is_null());
  EXPECT_EQ(papers, of("--method reference-pixel --sky-model auto"));
}

TEST_F(EstimateCommand, AListOnStandardInputGivesOneObjectALineInItsOrder) {
  const auto list = test_folder("command") / "list.txt";
  std::ofstream(list) << sky.string() << "\n" << sky.string() << "\n" << sky.string() << "\n";
  const auto outcome = ended(0, run_kasumi("estimate --json " + camera + " - <" + list.string()));
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
  const auto outcome = ended(2, run_kasumi("estimate --json " + camera + " " + broken.string() + " " + sky.string()));
  EXPECT_THAT(outcome.err, HasSubstr("broken.png"));
  EXPECT_THAT(outcome.out, HasSubstr("\"usable\":true"));
}

TEST_F(EstimateCommand, WhereNothingIsUsableTheExitCodeIsOneAndSaysWhy) {
  const auto black = test_folder("command") / "black.png";
  ASSERT_TRUE(write_png(black, Image<Rgb8>(400, 400)));
  const auto outcome = ended(1, run_kasumi("estimate --json " + camera + " " + black.string()));
  EXPECT_THAT(outcome.err, HasSubstr("the picture does not determine the air: "));
  const auto json = parse_json(outcome.out);
  EXPECT_FALSE(json["usable"]);
  EXPECT_FALSE(json["reason"].get<std::string>().empty());
  EXPECT_TRUE(json["turbidity"].is_null());
}

TEST_F(EstimateCommand, OneUsablePictureOfAListIsEnough) {
  const auto black = test_folder("command") / "black2.png";
  ASSERT_TRUE(write_png(black, Image<Rgb8>(400, 400)));
  EXPECT_EQ(run_kasumi("estimate " + camera + " " + black.string() + " " + sky.string()).code, 0);
  EXPECT_THAT(ended(1, run_kasumi("estimate " + camera + " </dev/null")).err, HasSubstr("empty"));
}

TEST_F(EstimateCommand, HalfAJpegIsRefusedOrToldOf) {
  const auto demo = source_folder() / "fixtures/demo";
  const auto half = test_folder("command") / "half.jpg";
  std::filesystem::copy_file(demo / "sky/frame-000000.jpg", half, std::filesystem::copy_options::overwrite_existing);
  std::filesystem::resize_file(half, std::filesystem::file_size(half) * 6 / 10);
  const auto options = fmt::format("estimate --json --calibration {}/fixture.toml --utc 2026-10-20T06:10:00Z {}",
                                   demo.string(), half.string());
  const auto refused = ended(2, run_kasumi(options));
  EXPECT_EQ(refused.out, "");
  EXPECT_THAT(refused.err, HasSubstr("half.jpg: damaged JPEG"));
  const auto told = run_kasumi(options + " --allow-damaged");
  EXPECT_NE(told.code, 2) << told.err;
  EXPECT_THAT(parse_json(told.out)["damaged"].get<std::string>(), HasSubstr("rows are whole"));

  const auto out = (test_folder("command") / "half.png").string();
  const auto retarget =
      fmt::format("retarget {} --distance-m 1000 --source-turbidity 2 --turbidity 3 --out {}", half.string(), out);
  EXPECT_EQ(run_kasumi(retarget).code, 2);
  EXPECT_THAT(ended(0, run_kasumi(retarget + " --airlight .5,.5,.5 --allow-damaged")).err,
              HasSubstr("what is left of it is used"));
}

TEST_F(EstimateCommand, TheFolderOfPlotsIsMade) {
  const auto folder = test_folder("command") / "plots/of/today";
  std::filesystem::remove_all(test_folder("command") / "plots");
  ended(0, run_kasumi(fmt::format("estimate --plot-dir {} {} {}", folder.string(), camera, sky.string())));
  EXPECT_GT(std::filesystem::file_size(folder / "sky.png.fit.png"), 1000u);
  EXPECT_THAT(ended(2, run_kasumi(fmt::format("estimate --plot-dir {0} {1} {0}", sky.string(), camera))).err,
              HasSubstr("--plot-dir"));
}

// The demo's own truth: its pictures' suns are mostly behind cloud, and a sun that is found there is the sun.
TEST(EstimateDemo, ASunFromTheImageIsNearOrRefused) {
  const auto demo = (source_folder() / "fixtures/demo").string();
  const auto of = [&](const std::string& options) {
    std::vector<nlohmann::json> found;
    const auto outcome = run_kasumi(fmt::format("estimate --json {} {}/sky/*.jpg", options, demo));
    std::istringstream lines(outcome.out);
    for (std::string line; std::getline(lines, line);) found.push_back(parse_json(line));
    EXPECT_EQ(found.size(), 6u) << outcome.err;
    return found;
  };
  const auto truth = of(fmt::format("--calibration {}/fixture.toml --utc 2026-10-20T06:10:00Z", demo));
  const auto seen = of(fmt::format("--calibration {}/fixture.toml --sun-from-image", demo));
  for (std::size_t i = 0; i < std::min(truth.size(), seen.size()); ++i) {
    if (seen[i]["sun_zenith_deg"].is_null()) continue;
    const auto direction = [](const nlohmann::json& json) {
      return direction_from(from_degrees(json["sun_zenith_deg"]), from_degrees(json["sun_azimuth_deg"]));
    };
    EXPECT_LE(to_degrees(angle_between(direction(seen[i]), direction(truth[i]))), 2.0) << i;
    EXPECT_THAT(seen[i]["sun_from"].get<std::string>(), HasSubstr("% sure"));
  }
}

// A name that is mistyped has no reference yet: it must not become one.
TEST(CalibrateCheck, ACalibrationThatIsNotThereIsRefused) {
  const auto demo = (source_folder() / "fixtures/demo").string();
  const auto typo = test_folder("command") / "typo.toml", other = test_folder("command") / "other.toml";
  std::filesystem::create_directories(typo.parent_path());
  std::ofstream(other) << "[site]\nlatitude_deg = 3\n";
  for (const auto& file : {typo, other}) {
    const auto outcome = run_kasumi(fmt::format("calibrate check {} --calibration {}", demo, file.string()));
    EXPECT_EQ(outcome.code, 2) << outcome.out << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("--calibration"));
    EXPECT_THAT(outcome.err, HasSubstr(file.string()));
    auto reference = file;
    EXPECT_FALSE(std::filesystem::exists(reference.replace_extension(".check.json")));
  }
}

TEST_F(EstimateCommand, EveryWrongOptionIsReportedAtOnce) {
  const auto outcome = ended(2, run_kasumi("estimate --sun-zenith-deg 10 --lat 40 --utc yesterday " + sky.string()));
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("--sun-azimuth-deg"), HasSubstr("--lon"), HasSubstr("--utc yesterday")));
}

TEST_F(EstimateCommand, APlotIsWrittenNextToTheImageOnRequest) {
  const auto plot = sky.string() + ".fit.png";
  std::filesystem::remove(plot);
  ASSERT_EQ(run_kasumi("estimate --plot " + camera + " " + sky.string()).code, 0);
  EXPECT_GT(std::filesystem::file_size(plot), 1000u);
}

// The demo's own air: T 2.4 of continental aerosol.
TEST(RetargetCommand, TheSourcesAerosolIsFoundInAPictureOfItsSky) {
  const auto demo = source_folder() / "fixtures" / "demo";
  const auto made = test_folder("command") / "retargeted.png";
  const auto of = [&](const std::string& options) {
    const auto outcome = ended(
        0, run_kasumi(fmt::format(
               "retarget {0}/scene/frame-000000.jpg --camera {0}/fixture.toml --sky {0}/sky/frame-000000.jpg --utc "
               "2026-10-20T06:10:00Z --distance-m 1500 --turbidity 4 --out {1} {2}",
               demo.string(), made.string(), options)));
    return outcome.out;
  };
  const auto known = of("--sky-model dome --aerosol continental");
  EXPECT_THAT(known, HasSubstr("source: aerosol optical depth 0.14"));
  EXPECT_THAT(known, HasSubstr("AOD0.305")) << "T 4 of the same aerosol";
  EXPECT_THAT(of(""), HasSubstr("source: aerosol optical depth 0.1"));
  const auto papers = of("--sky-model preetham");
  EXPECT_THAT(papers, HasSubstr("T4.00"));
  EXPECT_THAT(papers, ::testing::Not(HasSubstr("aerosol")));
  EXPECT_EQ(run_kasumi("retarget picture.png --sky-model perez").code, 2);
}

TEST(CommandLine, AnUnknownCommandIsBadInput) {
  EXPECT_EQ(run_kasumi("conjure").code, 2);
  EXPECT_EQ(run_kasumi("").code, 2);
  EXPECT_EQ(run_kasumi("--help").code, 0);
  EXPECT_EQ(run_kasumi("--version").code, 0);
}

TEST(CommandLine, AReplayWithoutAPictureIsNoSuccess) {
  const auto folder = test_folder("blind");
  std::filesystem::remove_all(folder);
  std::filesystem::copy(source_folder() / "fixtures/demo", folder, std::filesystem::copy_options::recursive);
  for (const auto& entry : std::filesystem::directory_iterator(folder / "scene"))
    if (entry.path().extension() == ".jpg") std::filesystem::resize_file(entry.path(), 1000);
  const auto outcome = run_kasumi("replay " + folder.string());
  EXPECT_EQ(outcome.code, 1) << outcome.out << outcome.err;
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("no picture was drawn"), HasSubstr("x scene camera: ")));
}

// What reads films and rare pictures comes with two hundred libraries, which would double the time to the first picture
// and the memory of a kiosk that never opens such a file.
TEST(CommandLine, TheProgramItselfLoadsNoLibraryOfFilms) {
  const auto loaded = run_kasumi("--version", "LD_TRACE_LOADED_OBJECTS=1");
  ASSERT_THAT(loaded.out, testing::HasSubstr("libopencv_core"));
  for (const char* library : {"libgdal", "libavcodec", "libopencv_imgcodecs", "libopencv_videoio"})
    EXPECT_THAT(loaded.out, testing::Not(testing::HasSubstr(library)));
}

TEST(CommandLine, AMissingFixtureIsBadInput) {
  EXPECT_THAT(ended(2, run_kasumi("replay /nowhere/at-all")).err, HasSubstr("/nowhere/at-all"));
}

TEST(CommandLine, AsksWhatAMistypedWordWasMeantFor) {
  for (const auto& [typed, meant] : {std::pair{"retraget a.png", "retarget"},
                                     {"calibrate lans a.png", "lens"},
                                     {"haze a.png --turbidty 8 --out b.png", "--turbidity"},
                                     {"haze a.png --scheme matchd --turbidity 8 --out b.png", "matched"}}) {
    const auto outcome = run_kasumi(typed);
    EXPECT_EQ(outcome.code, 2) << typed;
    EXPECT_THAT(outcome.err, HasSubstr(std::string("did you mean ") + meant + "?")) << typed;
  }
  EXPECT_THAT(run_kasumi("xylophone").err, testing::Not(HasSubstr("did you mean")));
}

}  // namespace
}  // namespace kasumi
