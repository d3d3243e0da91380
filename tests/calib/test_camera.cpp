#include <filesystem>

#include <opencv2/imgcodecs.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "calib/camera.hpp"
#include "calib/colour/colorimetry.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

fs::path folder() {
  const auto path = test_output_folder() / "calib";
  fs::create_directories(path);
  return path;
}

struct Read {
  Camera camera;
  std::string problems;
};
Read read(const std::string& text) {
  const auto root = ConfigTable::parse(text, folder() / "camera.toml").value();
  auto camera = read_camera(root.table("sky"), "sky");
  const auto finished = root.finish();
  return {std::move(camera), finished ? "" : finished.error().message};
}

const std::string kLens = "[sky.lens]\nmodel = 'equidistant'\nfov_deg = 180\ncircle_px = [99.5, 79.5, 78]\n";

std::string sky(const std::string& keys, const std::string& tables = kLens) {
  return "[sky]\nwidth = 200\nheight = 160\n" + keys + "\n" + tables;
}
const std::string kUp = "azimuth_up_deg = 30\nresponse = 'srgb'\n";

TEST(Camera, AnUpwardCameraSeesTheAzimuthOfItsTopAboveTheCentreAndTurnsCounterClockwise) {
  const auto [camera, problems] = read(sky(kUp));
  ASSERT_EQ(problems, "");
  const auto top = camera.direction_at({99.5, 79.5 - 39.0}).value();
  EXPECT_NEAR(to_degrees(zenith_angle(top)), 45.0, 1e-9);
  EXPECT_NEAR(to_degrees(azimuth_angle(top)), 30.0, 1e-9);
  const auto left = camera.direction_at({99.5 - 39.0, 79.5}).value();
  EXPECT_NEAR(to_degrees(azimuth_angle(left)), 120.0, 1e-9);
  EXPECT_FALSE(camera.direction_at({0.0, 0.0}));
}

TEST(Camera, ALevelCameraFacingEastSeesSouthToItsRightAndTheSkyAbove) {
  const auto [camera, problems] =
      read(sky("heading_deg = 90\npitch_deg = 0\nroll_deg = 0\nresponse = 'linear'",
               "[sky.lens]\nmodel = 'pinhole'\nfocal_px = [150, 150]\ncentre_px = [99.5, 79.5]\n"));
  ASSERT_EQ(problems, "");
  const auto ahead = camera.direction_at({99.5, 79.5}).value();
  EXPECT_NEAR(ahead.x, 1.0, 1e-12);
  const auto right = camera.direction_at({199.0, 79.5}).value();
  EXPECT_LT(right.y, -0.3);
  EXPECT_NEAR(right.z, 0.0, 1e-12);
  EXPECT_GT(camera.direction_at({99.5, 0.0})->z, 0.3);
  EXPECT_FALSE(camera.pixel_of({-1.0, 0.0, 0.0}));
}

TEST(Camera, ProjectingAndUnprojectingAreInverse) {
  for (const char* orientation : {"azimuth_up_deg = 77", "heading_deg = 200\npitch_deg = 80\nroll_deg = -12"}) {
    const auto [camera, problems] = read(sky(std::string(orientation) + "\nresponse = 'srgb'"));
    ASSERT_EQ(problems, "");
    for (const glm::dvec2 pixel : {glm::dvec2{99.5, 79.5}, {30.0, 60.0}, {150.2, 111.1}}) {
      const auto back = camera.pixel_of(camera.direction_at(pixel).value()).value();
      EXPECT_NEAR(back.x, pixel.x, 1e-9);
      EXPECT_NEAR(back.y, pixel.y, 1e-9);
    }
  }
}

TEST(Camera, LightIsCorrectedForResponseVignettingAndWhiteBalance) {
  const auto [camera, problems] =
      read(sky(kUp + "colour_space = 'sensor'\nwhite_balance = [2.0, 1.0, 1.6]",
               kLens + "[sky.vignetting]\nradius_px = 78\ncoefficients = [-0.2, -0.1, 0.0]\n"));
  ASSERT_EQ(problems, "");
  const glm::dvec3 light{0.1, 0.2, 0.3};
  const glm::dvec2 pixel{99.5 + 39.0, 79.5};  // half the reference radius: 1 - .2/4 - .1/16
  const auto encoded = camera.response.to_encoded(light * camera.white_balance * 0.94375);
  const auto found = camera.light_at(pixel, encoded);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], light[c], 1e-9);
  EXPECT_EQ(camera.light_to_xyz(), camera_to_xyz(camera.sensitivity));
}

TEST(Camera, AnSrgbCamerasLightIsConvertedToXyzByTheStandard) {
  EXPECT_EQ(read(sky(kUp)).camera.light_to_xyz(), srgb_to_xyz());
}

TEST(Camera, EveryKeyIsRead) {
  const fs::path spectral = test_output_folder() / "calib" / "three.csv";
  ASSERT_TRUE(write_text_file(spectral, "nm,r,g,b\n450,0,0,1\n500,0,1,0\n600,1,0,0\n650,0.1,0,0\n"));
  cv::Mat mask(160, 200, CV_8UC1, cv::Scalar(255));
  mask.at<std::uint8_t>(10, 20) = 7;
  ASSERT_TRUE(cv::imwrite((folder() / "mask.png").string(), mask));
  const auto [camera, problems] = read(
      sky("azimuth_up_deg = 0\nresponse = 'table'\nresponse_table_red = [0, 0.2, 1]\nresponse_table_green = [0, 1]\n"
          "response_table_blue = [0, 0.3, 0.6, 1]\ncolour_space = 'sensor'\nwhite_balance = [1.9, 1, 1.5]\n"
          "sensitivity = 'three.csv'\nyuv_encoding = 'bt709_limited'\nmask = 'mask.png'",
          kLens + "[sky.vignetting]\ncentre_px = [90, 80]\nradius_px = 70\ncoefficients = [-0.1, 0.0, 0.01]\n"));
  ASSERT_EQ(problems, "");
  EXPECT_EQ(camera.name, "sky");
  EXPECT_EQ(camera.width, 200);
  EXPECT_EQ(camera.height, 160);
  EXPECT_EQ(camera.lens->name(), "equidistant");
  EXPECT_NEAR(camera.response.to_light(glm::dvec3{0.5}).r, 0.2, 1e-12);
  EXPECT_NEAR(camera.response.to_light(glm::dvec3{0.5}).b, 0.45, 1e-12);
  EXPECT_EQ(camera.colour_space, Camera::ColourSpace::sensor);
  EXPECT_EQ(camera.white_balance, glm::dvec3(1.9, 1.0, 1.5));
  EXPECT_EQ(camera.sensitivity.name, "three");
  EXPECT_EQ(camera.yuv_encoding, YuvEncoding::bt709_limited);
  EXPECT_EQ(camera.mask.width(), 200);
  EXPECT_EQ(camera.mask.at(20, 10), 7);
  EXPECT_EQ(camera.mask.at(21, 10), 255);
  EXPECT_EQ(camera.vignetting.centre, glm::dvec2(90.0, 80.0));
}

TEST(Camera, VignettingIsCentredOnTheLensAndAbsentByDefault) {
  const auto camera = read(sky(kUp)).camera;
  EXPECT_EQ(camera.vignetting.at({10.0, 10.0}), 1.0);
  EXPECT_EQ(camera.vignetting.centre, glm::dvec2(99.5, 79.5));
}

TEST(Camera, ReportsAllProblemsAtOnce) {
  ASSERT_TRUE(cv::imwrite((folder() / "small.png").string(), cv::Mat(16, 20, CV_8UC1, cv::Scalar(255))));
  ASSERT_TRUE(write_text_file(folder() / "negative.csv", "nm,r,g,b\n450,0,0,1\n500,0,-1,0\n600,1,0,0\n"));
  const auto [camera, problems] = read(
      "[sky]\nwidth = 200\nheight = 160\nresponse = 'table'\nresponse_table = [0, 0.5, 0.25, 1]\n"
      "azimuth_up_deg = 10\nheading_deg = 3\nmask = 'small.png'\nsensitivity = 'negative.csv'\n"
      "white_balance = [1, 0, 1]\ncolour_space = 'cmyk'\nyuv_encoding = 'jpeg'\nfocal = 3\n"
      "[sky.lens]\nmodel = 'equidistant'\nfocal_px = 50\ncentre_px = [1000, 80]\n"
      "[sky.vignetting]\nradius_px = 80\ncentre_px = [99.5, 79.5]\ncoefficients = [-1.2, 0, 0]\n");
  for (const char* part :
       {"sky.response_table = [ 0, 0.5, 0.25, 1 ]: expected linear light", "sky.azimuth_up_deg = 10: expected either",
        "sky.mask = 'small.png': expected a PNG as large as the camera's pictures, 200 x 160 (it is 20 x 16)",
        "sky.sensitivity = 'negative.csv': expected", "negative.csv: green at 500 nm is -1", "sky.white_balance",
        "sky.colour_space = 'cmyk'", "sky.yuv_encoding = 'jpeg'", "sky.focal: unknown key", "sky.lens.centre_px"})
    EXPECT_THAT(problems, HasSubstr(part));
  EXPECT_TRUE(camera.lens);
}

TEST(Camera, VignettingThatReachesZeroInsideThePictureIsRefused) {
  const std::string vignetting = "[sky.vignetting]\nradius_px = 78\ncoefficients = [-1.2, 0, 0]\n";
  EXPECT_THAT(read(sky(kUp, kLens + vignetting)).problems,
              HasSubstr("sky.vignetting.coefficients = [ -1.2, 0, 0 ]: expected 1 + v2 r^2"));
}

TEST(Camera, VignettingThatReachesZeroOutsideTheImageCircleIsNot) {
  const std::string vignetting = "[sky.vignetting]\nradius_px = 78\ncoefficients = [-0.9, 0, 0]\n";
  EXPECT_EQ(read(sky(kUp, kLens + vignetting)).problems, "");
}

TEST(Camera, AGreySensitivityCannotServeARawCamera) {
  ASSERT_TRUE(write_text_file(folder() / "grey.csv", "nm,r,g,b\n450,1,1,1\n500,2,2,2\n600,1,1,1\n"));
  EXPECT_THAT(read(sky(kUp + "colour_space = 'sensor'\nsensitivity = 'grey.csv'")).problems,
              HasSubstr("three channels that differ"));
}

TEST(Camera, AnOrientationIsRequired) {
  EXPECT_THAT(read(sky("response = 'srgb'")).problems, HasSubstr("sky.azimuth_up_deg is missing: expected either"));
  EXPECT_THAT(read(sky("response = 'srgb'\nheading_deg = 10")).problems, HasSubstr("sky.pitch_deg is missing"));
}

TEST(Camera, AMissingTableIsOneProblem) {
  const auto [camera, problems] = read("");
  EXPECT_THAT(problems, HasSubstr("sky is missing: expected a table [sky]"));
  EXPECT_EQ(problems.find('\n'), std::string::npos) << problems;
  EXPECT_TRUE(camera.lens);
}

TEST(Camera, FilesThatAreNotPicturesAreRefusedAsMasks) {
  ASSERT_TRUE(write_text_file(folder() / "text.png", "no picture"));
  ASSERT_TRUE(write_text_file(folder() / "empty.png", ""));
  EXPECT_THAT(read(sky(kUp + "mask = 'text.png'")).problems, HasSubstr("sky.mask = 'text.png': expected a PNG"));
  EXPECT_THAT(read(sky(kUp + "mask = 'empty.png'")).problems, HasSubstr("sky.mask = 'empty.png': expected a PNG"));
}

// Some hundred bytes that claim 196 million pixels.
TEST(Camera, AMaskIsMeasuredBeforeItIsDecoded) {
  ASSERT_TRUE(cv::imwrite((folder() / "huge.png").string(), cv::Mat(160, 200, CV_8UC1, cv::Scalar(255))));
  auto bytes = read_file(folder() / "huge.png").value();
  for (const std::size_t at : {18, 22}) std::tie(bytes[at], bytes[at + 1]) = std::tuple(0x36, 0xb0);
  ASSERT_TRUE(write_file(folder() / "huge.png", bytes));
  EXPECT_THAT(read(sky(kUp + "mask = 'huge.png'")).problems, HasSubstr("200 x 160 (it is 14000 x 14000)"));
}

TEST(Camera, AnOcamcalibFileOfAnotherPictureSizeIsRefused) {
  ASSERT_TRUE(write_text_file(folder() / "cam.txt", "3 -80 0 1e-3\n1 5\n79.5 99.5\n1 0 0\n320 400\n"));
  const std::string lens = "[sky.lens]\nmodel = 'scaramuzza'\nocamcalib = 'cam.txt'\n";
  EXPECT_THAT(read(sky(kUp, lens)).problems, HasSubstr("a calibration of 200 x 160 pictures (it is of 400 x 320)"));
}

TEST(Camera, TheManualsExampleIsRead) {
  const auto manual = read_text_file(source_folder() / "docs/cameras.md").value();
  const auto start = manual.find("```toml\n") + 8;
  ASSERT_TRUE(cv::imwrite((folder() / "sky-mask.png").string(), cv::Mat(500, 500, CV_8UC1, cv::Scalar(255))));
  const auto root =
      ConfigTable::parse(manual.substr(start, manual.find("```", start) - start), folder() / "manual.toml").value();
  const auto sky_camera = read_camera(root.table("sky"), "sky");
  const auto scene_camera = read_camera(root.table("scene"), "scene");
  const auto finished = root.finish();
  EXPECT_TRUE(finished) << finished.error().message;
  EXPECT_NEAR(to_degrees(azimuth_angle(sky_camera.direction_at({251.3, 100.0}).value())), 12.0, 1e-9);
  EXPECT_NEAR(to_degrees(azimuth_angle(scene_camera.direction_at({968.2, 531.7}).value())), 214.5, 1e-9);
}

TEST(Site, IsReadWithinItsRanges) {
  const auto good = ConfigTable::parse("latitude_deg = 34.7\nlongitude_deg = 135.8\naltitude_m = 60", "s.toml").value();
  const auto site = read_site(good);
  EXPECT_TRUE(good.finish());
  EXPECT_EQ(site.latitude_deg, 34.7);
  EXPECT_EQ(site.longitude_deg, 135.8);
  EXPECT_EQ(site.altitude_m, 60.0);

  const auto bad = ConfigTable::parse("latitude_deg = 134.5\nlongitude_deg = 35.5", "s.toml").value();
  read_site(bad);
  const auto finished = bad.finish();
  ASSERT_FALSE(finished);
  EXPECT_THAT(finished.error().message, HasSubstr("latitude_deg = 134.5: expected a number from -90 to 90"));
  EXPECT_THAT(finished.error().message, HasSubstr("altitude_m is missing"));
}

}  // namespace
}  // namespace kasumi
