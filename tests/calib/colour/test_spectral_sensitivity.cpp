#include <cmath>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "calib/colour/spectral_sensitivity.hpp"
#include "tests/must.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

const fs::path kSpectral = shared_data_folder() / "spectral";

fs::path written(const std::string& name, const std::string& text) {
  const auto folder = test_output_folder() / "calib";
  fs::create_directories(folder);
  EXPECT_TRUE(write_text_file(folder / name, text));
  return folder / name;
}

std::string json_of(const std::string& index, const std::string& data) {
  return R"({"spectral_data": {"index": {"main": )" + index + R"(}, "data": {"main": )" + data + "}}}";
}

std::string refusal(const fs::path& path) {
  const auto result = read_spectral_sensitivity(path);
  EXPECT_FALSE(result) << path;
  return result ? "" : result.error().message;
}

TEST(SpectralSensitivity, RawtoacesJsonIsSortedByWavelengthAndNormalisedToOne) {
  const auto path = written(
      "camera.json", json_of(R"(["B", "R", "G"])", R"({"1000": [0, 0, 0], "400": [4, 1, 2], "700": [0, 8, 0.5]})"));
  const auto read = must(read_spectral_sensitivity(path));
  EXPECT_EQ(read->name, "camera");
  EXPECT_EQ(read->first_nm, 400.0);
  EXPECT_EQ(read->last_nm(), 1000.0);
  EXPECT_EQ(read->at(400.0), glm::dvec3(0.125, 0.25, 0.5));
  EXPECT_EQ(read->at(700.0), glm::dvec3(1.0, 0.0625, 0.0));
  EXPECT_NEAR(read->at(550.0).r, 0.5625, 1e-12);
}

TEST(SpectralSensitivity, CsvColumnsAreFoundByNameAndUnevenStepsAreInterpolated) {
  const auto path = written("camera.csv",
                            "# in percent\nwavelength_nm;Blue;ir;green_qe;R\r\n400;80;1;10;0\r\n405;60;1;20;0\r\n"
                            "425;20;1;40;0\r\n430;0;1;50;100\r\n");
  const auto read = must(read_spectral_sensitivity(path));
  EXPECT_EQ(read->step_nm, 5.0);
  ASSERT_EQ(read->samples.size(), 7U);
  EXPECT_NEAR(read->at(415.0).g, 0.3, 1e-12);
  EXPECT_NEAR(read->at(415.0).b, 0.4, 1e-12);
  EXPECT_NEAR(read->at(430.0).r, 1.0, 1e-12);
}

TEST(SpectralSensitivity, IsLinearBetweenSamplesAndZeroOutside) {
  const SpectralSensitivity two{"two", 500.0, 10.0, {{0.0, 0.2, 1.0}, {1.0, 0.4, 0.0}}};
  EXPECT_NEAR(two.at(502.5).r, 0.25, 1e-15);
  EXPECT_NEAR(two.at(502.5).g, 0.25, 1e-15);
  EXPECT_EQ(two.at(510.0), glm::dvec3(1.0, 0.4, 0.0));
  EXPECT_EQ(two.at(499.9), glm::dvec3(0.0));
  EXPECT_EQ(two.at(510.1), glm::dvec3(0.0));
}

TEST(SpectralSensitivity, BrokenFilesAreRefusedNamingFileChannelAndWavelength) {
  const std::string good_index = R"(["R", "G", "B"])";
  EXPECT_THAT(refusal(written("a.json", "{")), HasSubstr("a.json: not valid JSON"));
  EXPECT_THAT(refusal(written("b.json", "{}")), HasSubstr("spectral_data.index.main"));
  EXPECT_THAT(refusal(written("c.json", json_of(R"(["X", "Y", "Z"])", "{}"))), HasSubstr("\"R\", \"G\" and \"B\""));
  EXPECT_THAT(refusal(written("d.json", json_of(good_index, R"({"400": [1, 2]})"))),
              HasSubstr("spectral_data.data.main.400: expected 3 numbers"));
  EXPECT_THAT(refusal(written("e.json", json_of(good_index, R"({"400": [1, 2, null], "blue": [1, 2, 3]})"))),
              HasSubstr("\"blue\": expected a wavelength in nm"));
  EXPECT_THAT(refusal(written("f.json", json_of(good_index, R"({"400": [1,1,1], "500": [1,-2,1], "600": [1,1,1]})"))),
              HasSubstr("f.json: green at 500 nm is -2: expected a number >= 0"));
  EXPECT_THAT(refusal(written("g.json", json_of(good_index, R"({"0.4": [1,1,1], "0.5": [1,2,1], "0.6": [1,1,1]})"))),
              HasSubstr("wavelength 0.4: expected a number from 200 to 2500, in nm"));
  EXPECT_THAT(refusal(written("a.csv", "nm,r,g,b\n400,1,1,1\n500,1,nan,1\n600,1,1,1\n")),
              HasSubstr("green at 500 nm is nan"));
  EXPECT_THAT(refusal(written("b.csv", "nm,r,g\n400,1,1\n")), HasSubstr("no column for blue"));
  EXPECT_THAT(refusal(written("c.csv", "nm,r,g,b\n400,1,1,1\n390,1,1,1\n600,1,x,1\n")),
              HasSubstr("line 4: green \"x\""));
  EXPECT_THAT(refusal(written("d.csv", "nm,r,g,b\n400,1,1,1\n390,1,1,1\n600,1,1,1\n")), HasSubstr("390 after 400"));
  EXPECT_THAT(refusal(written("e.csv", "nm,r,g,b\n400,1,0,1\n410,1,0,1\n420,1,0,1\n")), HasSubstr("green is zero"));
  EXPECT_THAT(refusal(written("f.csv", "")), HasSubstr("no header line"));
  EXPECT_THAT(refusal(written("g.csv", "nm,r,g,b\n400,1,1,1\n")), HasSubstr("1 wavelengths: expected at least 3"));
  EXPECT_THAT(refusal(written("h.txt", "nm,r,g,b\n")), HasSubstr("expected a rawtoaces .json or a .csv"));
  EXPECT_THAT(refusal("/nowhere/x.csv"), HasSubstr("/nowhere/x.csv"));
}

TEST(SpectralSensitivity, TheGenericCameraHasThreeBellCurvesInTheRightPlaces) {
  const auto generic = generic_sensitivity();
  for (int c = 0; c < 3; ++c) {
    const double peak = std::array{600.0, 540.0, 450.0}[c];
    EXPECT_EQ(generic.at(peak)[c], 1.0);
    EXPECT_LT(generic.at(peak - 60.0)[c], 0.4);
    EXPECT_LT(generic.at(peak + 60.0)[c], 0.4);
  }
  EXPECT_TRUE(separates_daylight(generic));
}

TEST(SpectralSensitivity, MeasuredCamerasAreReadAsPublished) {
  if (!fs::exists(kSpectral)) GTEST_SKIP() << "no spectral data at " << kSpectral;
  const auto canon = must(read_spectral_sensitivity(kSpectral / "rawtoaces/Canon_EOS_5D_Mark_II_380_780_5.json"));
  EXPECT_EQ(canon->samples.size(), 81U);
  EXPECT_EQ(canon->step_nm, 5.0);
  // 400 nm over 405 nm, blue, straight from the file.
  EXPECT_NEAR(canon->at(400.0).b / canon->at(405.0).b, 0.020333479473463246 / 0.03511128699885068, 1e-12);

  const auto imx219 = must(read_spectral_sensitivity(kSpectral / "IMX219.csv"));
  EXPECT_EQ(imx219->first_nm, 400.0);
  EXPECT_EQ(imx219->last_nm(), 700.0);
  EXPECT_NEAR(imx219->at(400.0).b / imx219->at(400.0).r, 48.8481749159944 / 9.85823991842632, 1e-12);
}

}  // namespace
}  // namespace kasumi
