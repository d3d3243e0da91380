// kasumi calibrate response, from pictures of one view to the file with the camera's response.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "calib/camera.hpp"
#include "pipeline/site/files/picture_sink.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/install/calibrate/calibrating.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

constexpr int kSide = 90;
constexpr double kBlack = 12.0;  // of 255

double uniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1.0p-53;
}
// A sum of twelve uniform numbers: close enough to normal for noise.
double normal(std::mt19937_64& random) {
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += uniform(random);
  return sum;
}

std::uint8_t level(double light, std::mt19937_64& random) {
  const double noisy = light + std::sqrt(std::max(0.0, light) / 9000.0) * normal(random);
  const double gamma = std::pow(std::clamp(noisy, 0.0, 1.0), 1.0 / 1.8);
  return static_cast<std::uint8_t>(
      std::lround(std::clamp(kBlack + (255.0 - kBlack) * gamma + 0.4 * normal(random), 0.0, 255.0)));
}

// Relative illumination of this test's lens.
double shade(int x, int y) {
  const double r2 = (std::pow(x - 44.0, 2) + std::pow(y - 46.0, 2)) / (60.0 * 60.0);
  return 1.0 - 0.3 * r2 + 0.05 * r2 * r2;
}

Image<Rgb8> picture(double exposure, bool flat, std::mt19937_64& random) {
  std::mt19937_64 view(5);
  Image<Rgb8> made(kSide, kSide);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const double light = flat ? 0.7 * shade(x, y) : std::exp(-6.0 * (x + uniform(view)) / kSide);
      for (int c = 0; c < 3; ++c) made.at(x, y)[c] = level(exposure * light, random);
    }
  made.at(17, 60).y = 255;  // hot
  return made;
}

TEST(CalibrateResponse, ExposuresDarkFrameAndFlatFieldGiveCurveBlackLevelAndVignetting) {
  const auto folder = fresh_folder("calibrate-response");
  std::mt19937_64 random(1);
  std::string files, times;
  for (int j = 0; j < 8; ++j) {
    const double exposure = std::exp2(j - 5.0);
    const auto file = folder / fmt::format("e{}.png", j);
    ASSERT_TRUE(write_png(file, picture(exposure, false, random)));
    files += " " + file.string();
    times += fmt::format("{}{}", j == 0 ? "" : ",", 0.004 * exposure);
  }
  ASSERT_TRUE(write_png(folder / "dark.png", picture(0.0, false, random)));
  ASSERT_TRUE(write_png(folder / "flat.png", picture(1.0, true, random)));
  const auto file = folder / "calibration.toml";
  const auto outcome =
      run(fmt::format("response{} --exposures-s {} --dark {} --flat {} --circle 44,46,60 --merged {} --out {}", files,
                      times, (folder / "dark.png").string(), (folder / "flat.png").string(),
                      (folder / "merged.tiff").string(), file.string()));
  ASSERT_EQ(outcome.code, 0) << outcome.err << outcome.out;
  std::printf("%s", outcome.out.c_str());

  // The file's curve inverts the camera's.
  auto text = read_text_file(file).value();
  EXPECT_THAT(text, HasSubstr("hot pixel at (17, 60)"));
  text.insert(text.find("[sky]\n") + 6, "azimuth_up_deg = 0.0\n");
  text += "\n[sky.lens]\nmodel = \"equidistant\"\nfocal_px = 40.0\ncentre_px = [44.0, 46.0]\n";
  const auto root = ConfigTable::parse(text, file).value();
  const auto camera = read_camera(root.table("sky"), "sky");
  root.ignore("calibration");
  const auto whole = root.finish();
  ASSERT_TRUE(whole) << whole.error().message;
  const auto value = [](double light) { return (kBlack + (255.0 - kBlack) * std::pow(light, 1.0 / 1.8)) / 255.0; };
  const double gain = camera.response.to_light(glm::dvec3(value(0.25))).y / 0.25;
  for (const double light : {0.02, 0.05, 0.1, 0.4, 0.7, 0.9})
    EXPECT_NEAR(camera.response.to_light(glm::dvec3(value(light))).y / (gain * light), 1.0, 0.02) << light;
  EXPECT_LE(camera.response.to_light(glm::dvec3(kBlack / 255.0)).y, 2e-3);
  for (const glm::ivec2 at : {glm::ivec2(44, 46), glm::ivec2(70, 46), glm::ivec2(44, 85), glm::ivec2(80, 80)})
    EXPECT_NEAR(camera.vignetting.at(at) / shade(at.x, at.y), 1.0, 0.01);
  EXPECT_GT(std::filesystem::file_size(folder / "calibration.sky-response.png"), 1000u);
  EXPECT_GT(std::filesystem::file_size(folder / "merged.tiff"), 1000u);
}

// Exposures of this test's view in a folder, as arguments.
std::string written(const std::filesystem::path& folder, const std::vector<double>& exposures) {
  std::mt19937_64 random(2);
  std::string files;
  for (std::size_t j = 0; j < exposures.size(); ++j) {
    const auto file = folder / fmt::format("e{}.png", j);
    EXPECT_TRUE(write_png(file, picture(exposures[j], false, random)));
    files += " " + file.string();
  }
  return files;
}

TEST(CalibrateResponse, OneExposureRepeatedIsRefused) {
  const auto folder = fresh_folder("calibrate-response-same");
  const auto files = written(folder, {0.5, 0.5, 0.5});
  const auto file = folder / "calibration.toml";
  for (const std::string times : {"", "--exposures-s .01,.01,.01"}) {
    const auto outcome = ended(2, run(fmt::format("response{} {} --out {}", files, times, file.string())));
    EXPECT_THAT(outcome.err, HasSubstr("all exposures are the same"));
    EXPECT_THAT(outcome.err, HasSubstr("e0.png 1.0"));
    EXPECT_FALSE(std::filesystem::exists(file));
  }
}

TEST(CalibrateResponse, APictureOfAnotherViewIsNamed) {
  const auto folder = fresh_folder("calibrate-response-other");
  const auto files = written(folder, {0.125, 0.25, 0.5, 1.0});
  std::mt19937_64 random(3);
  auto other = picture(0.4, false, random);
  for (int y = 0; y < kSide; ++y) std::reverse(other.row(y), other.row(y) + kSide);
  ASSERT_TRUE(write_png(folder / "other.png", other));
  const auto file = folder / "calibration.toml";
  const auto outcome =
      run(fmt::format("response{} {} --out {}", files, (folder / "other.png").string(), file.string()));
  EXPECT_EQ(outcome.code, 2) << outcome.out;
  EXPECT_THAT(outcome.err, HasSubstr("1 of the 5 pictures"));
  EXPECT_THAT(outcome.err, HasSubstr("other.png: at best "));
  EXPECT_FALSE(std::filesystem::exists(file));
}

TEST(CalibrateResponse, AStackWithWrongTimesIsRefusedWithItsFigure) {
  const auto folder = fresh_folder("calibrate-response-times");
  const auto file = folder / "calibration.toml";
  const auto outcome =
      ended(2, run(fmt::format("response{} --exposures-s .01,.02,.02,.08,.1 --circle 44,46,25 --out {}",
                               written(folder, {1.0 / 16, 1.0 / 8, 1.0 / 4, 1.0 / 2, 1.0}), file.string())));
  EXPECT_THAT(outcome.err, HasSubstr("steps of 255 (rms), expected at most 3; worst in e"));
  EXPECT_FALSE(std::filesystem::exists(file));
}

// Details are in the data's README.
TEST(CalibrateResponse, TheSkyOverAlpnachIsAStackAndNineDaysAreNot) {
  const auto skies = shared_data_folder() / "sky";
  if (!std::filesystem::exists(skies / "skycam-alpnach") || !std::filesystem::exists(skies / "real"))
    GTEST_SKIP() << skies << " is not here: real stacks not tested";
  const auto file = fresh_folder("calibrate-response-real") / "calibration.toml";
  const auto stack =
      run(fmt::format("response {}/*_image.png --out {}", (skies / "skycam-alpnach").string(), file.string()));
  EXPECT_EQ(stack.code, 0) << stack.err;
  const auto days =
      ended(2, run(fmt::format("response {}/beijing-28*.jpg --out {}", (skies / "real").string(), file.string())));
  EXPECT_THAT(days.err, HasSubstr("beijing-281700.jpg: at best "));
  const auto hour =
      ended(2, run(fmt::format("response {}/unam-11*.jpg --out {}", (skies / "real").string(), file.string())));
  EXPECT_THAT(hour.err, HasSubstr("unam-11841.jpg: at best "));
}

TEST(CalibrateResponse, ReportsAllProblemsAtOnce) {
  const auto outcome = ended(2, run("response one.png --exposures-s 0.1,0.2 --circle 5,5,-1 --out " +
                                    (fresh_folder("r-wrong") / "c.toml").string()));
  for (const char* part : {"1 pictures", "2 times, expected 1", "--circle"}) EXPECT_THAT(outcome.err, HasSubstr(part));
}

}  // namespace
}  // namespace kasumi
