// Visibility from landmarks: by the command, and in the appliance's status.
#include <cmath>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/outside/json_text.hpp"
#include "estimator/air/attenuation.hpp"
#include "pipeline/kiosk/appliance/status.hpp"
#include "pipeline/kiosk/appliance/visibility_loop.hpp"
#include "pipeline/site/files/picture_sink.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/run_kasumi.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

constexpr int kPictureWidth = 320, kPictureHeight = 120, kLandmarks = 6;
double distance_of(int landmark) {
  return 1500.0 * std::pow(1.6, landmark);
}

// Dark squares in a row under an even sky, each behind its distance of air: at 1 nm, by the scattering model.
Image<Rgb8> squares_under(double turbidity) {
  const Camera camera;
  const glm::dvec3 sky{0.55, 0.6, 0.65};
  Image<Rgb8> picture(kPictureWidth, kPictureHeight);
  const auto put = [&](int x, int y, const glm::dvec3& light) {
    picture.at(x, y) = Rgb8(glm::round(255.0 * camera.response.to_encoded(light)));
  };
  for (int y = 0; y < kPictureHeight; ++y)
    for (int x = 0; x < kPictureWidth; ++x) put(x, y, sky);
  for (int i = 0; i < kLandmarks; ++i) {
    const auto left = attenuation_reference(spectral_measure(camera), ScatteringModel::morales2017,
                                            Turbidity{turbidity}, optical_path(0.0, 0.0, distance_of(i)));
    for (int y = 60; y < 90; ++y)
      for (int x = 10 + 50 * i; x < 40 + 50 * i; ++x) put(x, y, sky * (1.0 - 0.94 * left));
  }
  return picture;
}

std::string landmark_tables() {
  std::string text;
  for (int i = 0; i < kLandmarks; ++i)
    text += fmt::format(
        "[[landmarks]]\nname = \"square {}\"\ndistance_m = {}\nregion_px = [{}, 65, 20, 20]\nsky_px = [{}, 30, 20, "
        "20]\n",
        i, distance_of(i), 15 + 50 * i, 15 + 50 * i);
  return text;
}

class VisibilityCommand : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder = test_folder("visibility");
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder / "scenes");
    ASSERT_TRUE(write_png(folder / "scenes/1.png", squares_under(3.0)));
    ASSERT_TRUE(write_png(folder / "scenes/2.png", squares_under(6.0)));
    ASSERT_TRUE(write_text_file(folder / "landmarks.toml", landmark_tables()));
    fixtures::FisheyeRecipe recipe;
    recipe.turbidity = 3.0;
    recipe.size = 400;
    ASSERT_TRUE(write_png(folder / "sky.png", fixtures::sky_picture(recipe).pixels));
  }
  static std::string in_folder(const std::string& name) { return (folder / name).string(); }
  static std::string estimate_command(const std::string& scenes) {
    return fmt::format("estimate --json --scene {} --landmarks {} ", in_folder(scenes), in_folder("landmarks.toml"));
  }
  static std::filesystem::path folder;
};
std::filesystem::path VisibilityCommand::folder;

TEST_F(VisibilityCommand, ReportsTheVisibilityOfAPicture) {
  const auto outcome = ended(0, run_kasumi(estimate_command("scenes/1.png")));
  const auto json = parse_json(outcome.out);
  EXPECT_EQ(json["visibility"], "value");
  EXPECT_NEAR(json["visibility_m"].get<double>() / meteorological_range_m(Turbidity{3.0}, 0.0), 1.0, 0.1);
  EXPECT_NEAR(json["optical_range_m"].get<double>() / json["visibility_m"].get<double>(), 0.7658, 1e-3);
  EXPECT_NEAR(json["turbidity"].get<double>(), 3.0, 0.3);
  EXPECT_GT(json["sigma_m"].get<double>(), 0.0);
  EXPECT_EQ(json["readings"].size(), std::size_t{kLandmarks});
  EXPECT_TRUE(json["sky"].is_null());
}

TEST_F(VisibilityCommand, TakesAFolder) {
  const auto outcome = ended(0, run_kasumi(estimate_command("scenes")));
  std::istringstream lines(outcome.out);
  std::vector<double> turbidities;
  for (std::string line; std::getline(lines, line);) turbidities.push_back(parse_json(line)["turbidity"].get<double>());
  ASSERT_EQ(turbidities.size(), 2U);
  EXPECT_NEAR(turbidities[0] / 3.0, 1.0, 0.15);
  EXPECT_NEAR(turbidities[1] / 6.0, 1.0, 0.15);
}

TEST_F(VisibilityCommand, IsReportedNextToTheSkysOwnAndNotMixedWithIt) {
  const std::string sky =
      in_folder("sky.png") + " --circle 199.5,199.5,200 --sun-zenith-deg 58.4 --sun-azimuth-deg 180 --response srgb";
  const auto alone = run_kasumi("estimate --json " + sky);
  const auto same = ended(0, run_kasumi(estimate_command("scenes/1.png") + sky)),
             other = ended(0, run_kasumi(estimate_command("scenes/2.png") + sky));
  auto json = parse_json(same.out);
  EXPECT_EQ(json["landmarks"]["sky"]["agreement"], "agrees") << json["landmarks"]["sky"].dump();
  EXPECT_LT(json["landmarks"]["sky"]["sigmas"].get<double>(), 1.0);
  json = parse_json(other.out);
  // Air of T 3 in the sky and of 6 on the way: one picture of each is sure of no more.
  EXPECT_GT(json["landmarks"]["sky"]["sigmas"].get<double>(), 2.0) << json["landmarks"]["sky"].dump();
  json.erase("landmarks");
  EXPECT_EQ(json, parse_json(alone.out)) << "the sky's estimate is unchanged";
}

TEST_F(VisibilityCommand, ReportsAllProblemsOfTheLandmarks) {
  ASSERT_TRUE(write_text_file(folder / "wrong.toml",
                              "[[landmarks]]\nname = \"a\"\ndistance_m = 100\nregion_px = [310, 0, 20, 20]\n"
                              "[[landmarks]]\nname = \"b\"\ndistance_m = -3\nregion_px = [1, 1, 5, 5]\n"
                              "[[landmarks]]\nname = \"c\"\nregion_px = [1, 1, 5, 5]\ncontrst = 1\n"));
  const auto outcome =
      run_kasumi(fmt::format("estimate --scene {} --landmarks {}", in_folder("scenes/1.png"), in_folder("wrong.toml")));
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("within the scene camera's 320 x 120 pixels"));
  EXPECT_THAT(outcome.err, HasSubstr("distance_m = -3"));
  EXPECT_THAT(outcome.err, HasSubstr("a place needs a [site]"));
  EXPECT_THAT(outcome.err, HasSubstr("contrst"));
  EXPECT_NE(run_kasumi("estimate --scene " + in_folder("scenes/1.png")).code, 0) << "without --landmarks";
}

// The loop alone, under a manual clock.
class VisibilityLoopTest : public testing::Test {
 protected:
  VisibilityLoopTest() : clock(Utc{std::chrono::sys_days{std::chrono::year{2026} / 6 / 21} + 3h}) {
    start(landmark_tables());
  }
  // Starts or restarts the loop.
  void start(const std::string& landmarks, std::optional<std::filesystem::path> state_folder = {}) {
    auto content = std::make_shared<Content>();
    auto& installation = content->config.installation;
    installation.scene.width = kPictureWidth;
    installation.scene.height = kPictureHeight;
    const auto tables = ConfigTable::parse(landmarks, "kasumi.toml").value();
    installation.contrast_landmarks = read_contrast_landmarks(tables, std::nullopt, {kPictureWidth, kPictureHeight});
    installation.surroundings.sky_model = DaylightModel::preetham;  // whose T the squares are drawn under
    content->config.state_folder = std::move(state_folder);
    mailboxes.scene.visibility_wants_picture = false;
    loop.emplace(std::move(content), clock, mailboxes);
  }
  // Relative sigma of the visibility from one picture.
  double sigma_of_one_picture(double turbidity) {
    supply_picture(turbidity);
    return reported()["sigma_m"].get<double>() / reported()["visibility_m"].get<double>();
  }
  // Supplies one picture a minute, as the scene camera's loop does on request.
  void supply_picture(double turbidity) {
    tell_sky();
    const auto again = loop->step();
    EXPECT_TRUE(mailboxes.scene.visibility_wants_picture.exchange(false)) << "a picture is requested";
    EXPECT_LE(again - clock.now(), 1s);
    mailboxes.visibility.scene.put({{}, squares_under(turbidity), false});
    loop->step();
    if (auto update = mailboxes.status->visibility.take()) latest = std::move(*update);
    EXPECT_FALSE(mailboxes.scene.visibility_wants_picture) << "one a minute is enough";
    clock.advance(1min);
  }
  void set_sky(double turbidity, double height = 0.6) {
    sky_ = {Turbidity{turbidity},
            0.1,
            {SunDirection{0.0, std::sqrt(1.0 - height * height), height}, SkyCondition::overcast}};
    tell_sky();
  }
  // The sky's loop tells its news once a second.
  void tell_sky() {
    if (!sky_) return;
    sky_->told = clock.now();
    mailboxes.visibility.sky.put(*sky_);
  }
  nlohmann::json reported() {
    Status status;
    status.visibility = latest;
    return parse_json(status_json(status))["visibility"];
  }
  ManualClock clock;
  Mailboxes mailboxes;
  std::optional<VisibilityLoop> loop;
  VisibilityStatus latest;

 private:
  std::optional<ObservedTurbidity> sky_;
};

TEST_F(VisibilityLoopTest, ReportsTheVisibilityNextToTheSkysAir) {
  EXPECT_TRUE(reported().is_null());
  set_sky(3.0);
  supply_picture(3.0);
  const auto json = reported();
  EXPECT_NEAR(json["visibility_m"].get<double>() / meteorological_range_m(Turbidity{3.0}, 0.0), 1.0, 0.1);
  EXPECT_TRUE(json["bound"].is_null());
  EXPECT_EQ(json["agreement"], "agrees") << json.dump();
  EXPECT_EQ(json["finding"], false);
  EXPECT_EQ(json["landmarks"], kLandmarks);
  EXPECT_TRUE(json["saturation"].is_null()) << "one picture does not tell";
  VisibilityStatus later = latest;
  EXPECT_TRUE(json["tone_exponent"].is_null());
  later.air->camera = {1.6, 0.1, 40};
  later.air->tone = {1.2, 0.05, 40};
  latest = later;
  EXPECT_EQ(reported()["saturation"], 1.6);
  EXPECT_EQ(reported()["saturation_sigma"], 0.16);
  EXPECT_EQ(reported()["tone_exponent"], 1.2);
  EXPECT_EQ(reported()["tone_exponent_sigma"], 0.06);
}

TEST_F(VisibilityLoopTest, TellsTheSkysLoopWhatItReads) {
  EXPECT_FALSE(mailboxes.sky.scene_air.take());
  supply_picture(6.0);
  const auto reading = mailboxes.sky.scene_air.take();
  ASSERT_TRUE(reading && reading->path);
  EXPECT_EQ(reading->when, clock.now() - 1min);
  using Kind = PathReading::Channel::Kind;
  for (const auto& channel : reading->path->channels) EXPECT_EQ(channel.kind, Kind::value);
  EXPECT_GT(reading->path->channels[2].per_m, reading->path->channels[0].per_m) << "blue light loses more";
  set_sky(3.0, 0.02);
  supply_picture(6.0);
  EXPECT_FALSE(mailboxes.sky.scene_air.take()) << "nothing is read under a low sun";
}

TEST_F(VisibilityLoopTest, ALastingDisagreementIsReportedUntilItEnds) {
  set_sky(2.0);
  for (int i = 0; i < 4; ++i) supply_picture(6.0);
  EXPECT_EQ(reported()["agreement"], "disagrees");
  EXPECT_EQ(reported()["finding"], false) << "not for a passing disagreement";
  supply_picture(6.0);
  EXPECT_EQ(reported()["finding"], true);
  EXPECT_THAT(reported()["words"].get<std::string>(), HasSubstr("standard deviations apart"));
  EXPECT_NEAR(reported()["turbidity"].get<double>() / 6.0, 1.0, 0.2) << "never an average";
  set_sky(6.0);
  supply_picture(6.0);
  EXPECT_EQ(reported()["finding"], false);
}

TEST_F(VisibilityLoopTest, LandmarkPropertiesSurviveARestart) {
  const auto folder = test_folder("visibility-state");
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  start(landmark_tables(), folder);
  const double at_first = sigma_of_one_picture(3.0);
  for (int i = 0; i < 10; ++i) {
    clock.advance(30min);
    supply_picture(2.5 + 0.2 * i);
  }
  const double learnt = sigma_of_one_picture(3.0);
  EXPECT_LT(learnt, 0.95 * at_first);

  start(landmark_tables(), folder);
  EXPECT_NEAR(sigma_of_one_picture(3.0) / learnt, 1.0, 0.02);

  auto moved = landmark_tables();
  moved.replace(moved.find("15, 65"), 2, "16");
  start(moved, folder);
  EXPECT_NEAR(sigma_of_one_picture(3.0) / at_first, 1.0, 0.02) << "another box is another landmark";

  start(landmark_tables(), folder);
  supply_picture(3.0);
  const auto kept = parse_json(read_text_file(folder / "landmarks.json").value());
  auto damaged = kept, calibrated = kept, older = kept;
  damaged["kept"][0]["readings"][0][1] = "grey";
  calibrated["response"][4] = calibrated["response"][4].get<double>() + 0.01;  // the scene camera's, since then
  older.erase("response");
  ASSERT_TRUE(write_text_file(folder / "landmarks.json", older.dump()));
  start(landmark_tables(), folder);
  EXPECT_LT(sigma_of_one_picture(3.0), 0.99 * at_first);
  for (const auto& text : {damaged.dump(), calibrated.dump(), std::string("{\"landmarks\": 3"), std::string()}) {
    ASSERT_TRUE(write_text_file(folder / "landmarks.json", text));
    start(landmark_tables(), folder);
    EXPECT_NEAR(sigma_of_one_picture(3.0) / at_first, 1.0, 0.02) << text;
  }
}

TEST_F(VisibilityLoopTest, ReportsNothingUnderALowSunOrWithoutASky) {
  supply_picture(3.0);
  EXPECT_EQ(reported()["agreement"], "unknown");
  EXPECT_FALSE(reported()["visibility_m"].is_null()) << "the landmarks need no sky camera";
  set_sky(3.0, 0.02);
  supply_picture(3.0);
  EXPECT_TRUE(reported()["visibility_m"].is_null());
  EXPECT_THAT(reported()["reason"].get<std::string>(), HasSubstr("sun is too low"));
}

}  // namespace
}  // namespace kasumi
