// Lenses of other programs, against those programs' own definitions of their models, written here a second time or
// computed by OpenCV. Pixels of COLMAP, Agisoft and Hugin count from the corner of the picture.
#include <cmath>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>

#include "base/files.hpp"
#include "calib/lens/import_lens.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::AllOf;
using testing::HasSubstr;

Result<ImportedLens> imported_from(const std::string& text, const ImportRequest& options = {},
                                   const char* name = "lens.any") {
  const auto folder = test_output_folder() / "foreign";
  std::filesystem::create_directories(folder);
  EXPECT_TRUE(write_text_file(folder / name, text));
  return import_lens(folder / name, options);
}
std::string refusal_of(const std::string& text, const ImportRequest& options = {}) {
  const auto read = imported_from(text, options);
  return read ? "accepted" : read.error().message;
}

// Where the program itself puts a direction, by angle off the axis and turn from the right clockwise.
using Definition = std::function<glm::dvec2(double theta, double phi)>;

void expect_projection(const Result<ImportedLens>& imported, const std::string& program, const Definition& wanted,
                       std::vector<double> angles_deg = {0.0, 30.0, 60.0, 85.0}) {
  ASSERT_TRUE(imported) << imported.error().message;
  EXPECT_EQ(imported->program, program);
  const auto lens = make_lens(imported->lens);
  for (const double angle_deg : angles_deg)
    for (int turn = 0; turn < 8; ++turn) {
      const double theta = angle_deg * kPi / 180.0, phi = 0.25 * kPi * turn + 0.1;
      const auto is =
          lens->project({std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)});
      ASSERT_TRUE(is) << program << " " << angle_deg;
      const auto by = wanted(theta, phi);
      EXPECT_LT(std::hypot(is->x - by.x, is->y - by.y), 0.1)
          << program << " " << angle_deg << " deg: " << is->x << " " << is->y << " instead of " << by.x << " " << by.y;
    }
}

constexpr const char* kHead = "%YAML:1.0\n---\nimage_width: 1600\nimage_height: 1500\n";
std::string opencv_matrix(const std::string& name, const std::vector<double>& data, std::size_t columns) {
  std::string text = fmt::format("{}: !!opencv-matrix\n   rows: {}\n   cols: {}\n   dt: d\n   data: [ ", name,
                                 data.size() / columns, columns);
  for (std::size_t i = 0; i < data.size(); ++i) text += (i ? ", " : "") + fmt::format("{:#}", data[i]);
  return text + " ]\n";
}
const std::string kMatrix = opencv_matrix("camera_matrix", {450.5, 0.0, 801.25, 0.0, 452.0, 748.5, 0.0, 0.0, 1.0}, 3);
const std::string kSkewed = opencv_matrix("K", {450.5, 7.5, 801.25, 0.0, 452.0, 748.5, 0.0, 0.0, 1.0}, 3);
const std::vector<double> kBent{0.02, -0.01, 0.003, -0.0005};

Definition by_opencv_fisheye(double alpha) {
  return [alpha](double theta, double phi) {
    const cv::Mat k = (cv::Mat_<double>(3, 3) << 450.5, 0.0, 801.25, 0.0, 452.0, 748.5, 0.0, 0.0, 1.0), d(kBent);
    if (theta == 0.0) return glm::dvec2{801.25, 748.5};
    const std::vector<cv::Point3d> points{
        {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)}};
    std::vector<cv::Point2d> pixels;
    cv::fisheye::projectPoints(points, pixels, cv::Vec3d(), cv::Vec3d(), k, d, alpha);
    return glm::dvec2{pixels[0].x, pixels[0].y};
  };
}
Definition by_opencv_pinhole(const std::vector<double>& d) {
  return [d](double theta, double phi) {
    const cv::Mat k = (cv::Mat_<double>(3, 3) << 450.5, 0.0, 801.25, 0.0, 452.0, 748.5, 0.0, 0.0, 1.0);
    const std::vector<cv::Point3d> points{
        {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)}};
    std::vector<cv::Point2d> pixels;
    cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), k, d, pixels);
    return glm::dvec2{pixels[0].x, pixels[0].y};
  };
}
// Mei's: the sphere's point seen from xi behind the middle, then Brown's distortion.
Definition by_omnidir(double xi, const std::vector<double>& d) {
  return [xi, d](double theta, double phi) {
    const double x = std::sin(theta) * std::cos(phi) / (std::cos(theta) + xi),
                 y = std::sin(theta) * std::sin(phi) / (std::cos(theta) + xi), r2 = x * x + y * y;
    const double radial = 1.0 + d[0] * r2 + d[1] * r2 * r2;
    return glm::dvec2{450.5 * (x * radial + 2.0 * d[2] * x * y + d[3] * (r2 + 2.0 * x * x)) + 801.25,
                      452.0 * (y * radial + d[2] * (r2 + 2.0 * y * y) + 2.0 * d[3] * x * y) + 748.5};
  };
}

TEST(ForeignLens, OpencvsFisheyeWithAndWithoutSkew) {
  const auto d = opencv_matrix("D", kBent, 1);
  expect_projection(imported_from(kHead + ("fisheye_model: 1\n" + kMatrix) + d), "OpenCV", by_opencv_fisheye(0.0));
  expect_projection(imported_from(kHead + ("fisheye_model: 1\n" + kSkewed) + d), "OpenCV",
                    by_opencv_fisheye(7.5 / 450.5));
  expect_projection(imported_from(kHead + ("fisheye_model: 1\nalpha: 0.02\n" + kMatrix) + d), "OpenCV",
                    by_opencv_fisheye(0.02));
  for (const char* name : {"KannalaBrandt8", "equidistant", "fisheye"})
    expect_projection(imported_from(kHead + fmt::format("Camera.type: \"{}\"\n", name) + kMatrix + d), "OpenCV",
                      by_opencv_fisheye(0.0));
}

TEST(ForeignLens, FourCoefficientsWithoutAModelsNameAskForIt) {
  const auto text = kHead + kMatrix + opencv_matrix("D", kBent, 1);
  EXPECT_THAT(refusal_of(text), HasSubstr("--model pinhole or --model opencv_fisheye"));
  expect_projection(imported_from(text, {"opencv_fisheye", {}}), "OpenCV", by_opencv_fisheye(0.0));
  expect_projection(imported_from(text, {"pinhole", {}}), "OpenCV", by_opencv_pinhole(kBent), {0.0, 30.0});
}

// As scripts in Python write them.
TEST(ForeignLens, ScriptsOfOpencvsInJsonAndPlainYaml) {
  expect_projection(imported_from("{\"DIM\": [1600, 1500], \"K\": [[450.5, 0.0, 801.25], [0.0, 452.0, 748.5], [0.0, "
                                  "0.0, 1.0]], \"D\": [[0.02], [-0.01], [0.003], [-0.0005]], \"ret\": 0.2}",
                                  {"opencv_fisheye", {}}),
                    "OpenCV", by_opencv_fisheye(0.0));
  expect_projection(imported_from("camera_matrix:\n- - 450.5\n  - 0.0\n  - 801.25\n- - 0.0\n  - 452.0\n  - 748.5\n- - "
                                  "0.0\n  - 0.0\n  - 1.0\ndist_coeff:\n- - -0.05\n  - 0.008\n  - 0.001\n  - -0.0005\n"
                                  "  - -0.0006\nimage_size: [1600, 1500]\n"),
                    "OpenCV", by_opencv_pinhole({-0.05, 0.008, 1e-3, -5e-4, -0.0006}), {0.0, 30.0, 55.0});
}

TEST(ForeignLens, OpencvsPinholeItsRationalModelAndItsOwnProgram) {
  const std::vector<double> brown{-0.05, 0.008, 1e-3, -5e-4, -0.0006};
  expect_projection(imported_from(kHead + kMatrix + opencv_matrix("D", brown, 5)), "OpenCV", by_opencv_pinhole(brown),
                    {0.0, 30.0, 55.0});
  // Radial: it becomes a polynomial.
  const std::vector<double> rational{0.3, 0.04, 0.0, 0.0, 0.001, 0.35, 0.06, 0.003};
  expect_projection(imported_from(kHead + kMatrix + opencv_matrix("D", rational, 8)), "OpenCV",
                    by_opencv_pinhole(rational), {0.0, 30.0, 55.0});
  // As opencv_interactive-calibration writes it.
  const auto own = imported_from(
      "<?xml version=\"1.0\"?>\n<opencv_storage>\n<calibrationDate>\"Fri\"</calibrationDate>\n"
      "<framesCount>20</framesCount>\n<cameraResolution>\n  1600 1500</cameraResolution>\n"
      "<cameraMatrix type_id=\"opencv-matrix\"><rows>3</rows><cols>3</cols><dt>d</dt><data>450.5 0. 801.25 0. 452. "
      "748.5 0. 0. 1.</data></cameraMatrix>\n<cameraMatrix_std_dev type_id=\"opencv-matrix\"><rows>4</rows>"
      "<cols>1</cols><dt>d</dt><data>1. 1. 1. 1.</data></cameraMatrix_std_dev>\n"
      "<dist_coeffs type_id=\"opencv-matrix\"><rows>1</rows><cols>5</cols><dt>d</dt><data>-0.05 0.008 1e-3 -5e-4 "
      "-0.0006</data></dist_coeffs>\n<avg_reprojection_error>0.3</avg_reprojection_error>\n</opencv_storage>\n");
  expect_projection(own, "OpenCV", by_opencv_pinhole(brown), {0.0, 30.0, 55.0});
  EXPECT_EQ(own->width, 1600);
  EXPECT_EQ(own->rms_px, 0.3);
}

TEST(ForeignLens, OpencvsOmnidirHasXi) {
  const std::vector<double> d{-0.1, 0.02, 0.0, 0.0};
  expect_projection(imported_from(kHead + ("xi: 1.2\n" + kMatrix) + opencv_matrix("D", d, 1)), "OpenCV",
                    by_omnidir(1.2, d));
  // Tangential terms bend a fisheye as none of our models does.
  EXPECT_THAT(refusal_of(kHead + ("xi: 1.2\n" + kMatrix) + opencv_matrix("D", {-0.1, 0.02, 0.01, -0.01}, 1)),
              HasSubstr("would move pixels by up to"));
}

TEST(ForeignLens, RosCameraInfo) {
  const auto text = [](const std::string& model, const std::string& d) {
    return "image_width: 1600\nimage_height: 1500\ncamera_name: head\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
           "  data: [450.5, 0.000000, 801.25, 0.0, 452.0,\n         748.5, 0.0, 0.0, 1.0]\ndistortion_model: " +
           model + "\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [" + d +
           "]\nrectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n"
           "projection_matrix:\n  rows: 3\n  cols: 4\n  data: [400, 0, 800, 0, 0, 400, 700, 0, 0, 0, 1, 0]\n";
  };
  expect_projection(imported_from(text("plumb_bob", "-0.05, 0.008, 0.001, -0.0005, -0.0006")), "ROS",
                    by_opencv_pinhole({-0.05, 0.008, 0.001, -0.0005, -0.0006}), {0.0, 30.0, 55.0});
  expect_projection(imported_from(text("equidistant", "0.02, -0.01, 0.003, -0.0005")), "ROS", by_opencv_fisheye(0.0));
  expect_projection(imported_from(text("rational_polynomial", "0.3, 0.04, 0, 0, 0.001, 0.35, 0.06, 0.003")), "ROS",
                    by_opencv_pinhole({0.3, 0.04, 0.0, 0.0, 0.001, 0.35, 0.06, 0.003}), {0.0, 30.0, 55.0});
  EXPECT_THAT(refusal_of(text("my_model", "0, 0, 0, 0, 0")), HasSubstr("model \"my_model\": expected plumb_bob"));
}

// Windows' mark at the beginning and tabs behind colons; lists below keys in one line.
TEST(ForeignLens, YamlInOtherClothes) {
  expect_projection(
      imported_from("\xef\xbb\xbfimage_width:\t1600\r\nimage_height: 1500\r\ncamera_name: head\r\ncamera_matrix: "
                    "{rows: 3, cols: 3, data: "
                    "[450.5, 0, 801.25, 0,\r\n  452.0, 748.5, 0, 0, 1]}\r\ndistortion_model: plumb_bob\r\n"
                    "distortion_coefficients: {rows: 1, cols: 5, data: [-0.05, 0.008, 0.001, -0.0005, -0.0006]}\r\n"),
      "OpenCV", by_opencv_pinhole({-0.05, 0.008, 0.001, -0.0005, -0.0006}), {0.0, 30.0, 55.0});
  EXPECT_THAT(refusal_of("image_width: 1600\nimage_height: 1500\ncamera_matrix: {rows: 3, cols: 3, data: [450.5]}\n"),
              HasSubstr("camera_matrix: expected 9 numbers"));
}

// As `rostopic echo` and `ros2 topic echo` print it.
TEST(ForeignLens, RosMessagesOfWholePicturesAlone) {
  const std::string ros1 =
      "height: 1500\nwidth: 1600\ndistortion_model: \"plumb_bob\"\nD: [-0.2, 0.05, 0.001, -0.0007, 0.003]\n"
      "K: [450.5, 0.0, 801.25, 0.0, 452.0, 748.5, 0.0, 0.0, 1.0]\nR: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n"
      "P: [450, 0, 801, 0, 0, 452, 748, 0, 0, 0, 1, 0]\nbinning_x: 0\nbinning_y: 1\n";
  const std::string whole = "roi:\n  x_offset: 0\n  y_offset: 0\n  height: 0\n  width: 0\n  do_rectify: False\n";
  const auto first = imported_from(ros1 + whole);
  ASSERT_TRUE(first) << first.error().message;
  EXPECT_EQ(first->foreign_model, "plumb_bob");
  std::string ros2 = ros1;
  for (const char letter : {'D', 'K', 'R', 'P'})
    ros2[ros2.find(std::string("\n") + letter + ":") + 1] = static_cast<char>(std::tolower(letter));
  const auto second = imported_from(ros2 + whole);
  ASSERT_TRUE(second) << second.error().message;
  const glm::dvec3 ray{0.3, -0.2, 1.0};
  EXPECT_EQ(*make_lens(second->lens)->project(ray), *make_lens(first->lens)->project(ray));
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = ros1 + whole;
    return refusal_of(text.replace(text.find(from), from.size(), to));
  };
  EXPECT_THAT(with("binning_x: 0", "binning_x: 2"), HasSubstr("binning_x: 2 pixels become one"));
  EXPECT_THAT(with("x_offset: 0", "x_offset: 200"), HasSubstr("roi.x_offset: 200"));
  EXPECT_THAT(with("  width: 0", "  width: 800"), HasSubstr("roi.width: 800"));
}

TEST(ForeignLens, ListsOfAnotherLengthOrWithoutNumbersAreRefused) {
  const auto bent = [](const std::string& numbers) {
    return refusal_of(kHead + kMatrix + "distortion_coefficients: [" + numbers + "]\n");
  };
  EXPECT_THAT(bent("-0.2, 0.05, 0, 0, 0.01, 0.1, 0.2"), HasSubstr("7 numbers: expected 4, 5, 8 or 12"));
  EXPECT_THAT(bent("-0.2, .nan, 0, 0, 0.01"), HasSubstr("distortion_coefficients: \".nan\" among its numbers"));
  EXPECT_THAT(bent("-0.2, inf, 0, 0, 0.01"), HasSubstr("\"inf\" among its numbers"));
}

TEST(ForeignLens, KalibrsCamchain) {
  const auto text = [](const std::string& camera, const std::string& n, const std::string& bent, const std::string& d) {
    return "cam0:\n  cam_overlaps: []\n  camera_model: " + camera + "\n  distortion_coeffs: [" + d +
           "]\n  distortion_model: " + bent + "\n  intrinsics: [" + n +
           "]\n  resolution: [1600, 1500]\n  rostopic: /cam0/image_raw\n  T_cam_imu:\n  - [1.0, 0.0, 0.0, 0.1]\n"
           "  - [0.0, 1.0, 0.0, 0.2]\n";
  };
  const std::string four = "450.5, 452.0, 801.25, 748.5";
  expect_projection(imported_from(text("pinhole", four, "equidistant", "0.02, -0.01, 0.003, -0.0005")), "Kalibr",
                    by_opencv_fisheye(0.0));
  expect_projection(imported_from(text("pinhole", four, "radtan", "-0.05, 0.008, 0.001, -0.0005")), "Kalibr",
                    by_opencv_pinhole({-0.05, 0.008, 0.001, -0.0005}), {0.0, 30.0, 55.0});
  expect_projection(imported_from(text("omni", "1.2, " + four, "radtan", "-0.1, 0.02, 0.0, 0.0")), "Kalibr",
                    by_omnidir(1.2, {-0.1, 0.02, 0.0, 0.0}));
  // The double sphere and the extended unified model, as their authors define them.
  expect_projection(
      imported_from(text("ds", "-0.2, 0.6, " + four, "none", "")), "Kalibr",
      [](double theta, double phi) {
        const double x = std::sin(theta) * std::cos(phi), y = std::sin(theta) * std::sin(phi), z = std::cos(theta);
        const double d2 = std::sqrt(x * x + y * y + (-0.2 + z) * (-0.2 + z)), depth = 0.6 * d2 + 0.4 * (-0.2 + z);
        return glm::dvec2{450.5 * x / depth + 801.25, 452.0 * y / depth + 748.5};
      },
      {0.0, 30.0, 60.0});
  expect_projection(
      imported_from(text("eucm", "0.6, 1.1, " + four, "none", "")), "Kalibr", [](double theta, double phi) {
        const double x = std::sin(theta) * std::cos(phi), y = std::sin(theta) * std::sin(phi), z = std::cos(theta);
        const double depth = 0.6 * std::sqrt(1.1 * (x * x + y * y) + z * z) + 0.4 * z;
        return glm::dvec2{450.5 * x / depth + 801.25, 452.0 * y / depth + 748.5};
      });
  EXPECT_THAT(refusal_of(text("ds", "-0.2, 0.6, " + four, "none", "-0.28, 0.07, 0, 0")),
              HasSubstr("\"none\" of ds with 4 distortion_coeffs: expected none, and no coefficients"));
  EXPECT_THAT(refusal_of(text("pinhole", four, "strange", "0")), HasSubstr("distortion_model \"strange\""));
}

TEST(ForeignLens, ColmapsCamerasCountFromTheCorner) {
  const std::string head = "# Camera list with one line of data per camera:\n# Number of cameras: 1\n";
  const auto shifted = [](const Definition& inner) {
    return [inner](double theta, double phi) { return inner(theta, phi) - glm::dvec2(0.5); };
  };
  expect_projection(
      imported_from(head + "1 OPENCV_FISHEYE 1600 1500 450.5 452 801.25 748.5 0.02 -0.01 0.003 -0.0005\n"), "COLMAP",
      shifted(by_opencv_fisheye(0.0)));
  expect_projection(imported_from(head + "1 OPENCV 1600 1500 450.5 452 801.25 748.5 -0.05 0.008 0.001 -0.0005\n"),
                    "COLMAP", shifted(by_opencv_pinhole({-0.05, 0.008, 0.001, -0.0005})), {0.0, 30.0, 55.0});
  expect_projection(
      imported_from(head + "1 FULL_OPENCV 1600 1500 450.5 452 801.25 748.5 .3 .04 0 0 .001 .35 .06 .003\n"), "COLMAP",
      shifted(by_opencv_pinhole({0.3, 0.04, 0.0, 0.0, 0.001, 0.35, 0.06, 0.003})), {0.0, 30.0, 55.0});
  expect_projection(imported_from(head + "3 SIMPLE_RADIAL_FISHEYE 1600 1500 450 800 750 0.01\n"), "COLMAP",
                    [](double theta, double phi) {
                      const double r = 450.0 * theta * (1.0 + 0.01 * theta * theta);
                      return glm::dvec2{799.5 + r * std::cos(phi), 749.5 + r * std::sin(phi)};
                    });
  expect_projection(imported_from(head + "3 SIMPLE_PINHOLE 1600 1500 450 800 750\n"), "COLMAP",
                    [](double theta, double phi) {
                      return glm::dvec2{799.5 + 450.0 * std::tan(theta) * std::cos(phi),
                                        749.5 + 450.0 * std::tan(theta) * std::sin(phi)};
                    },
                    {0.0, 30.0, 60.0});
  // The model of one angle, omega.
  expect_projection(imported_from(head + "1 FOV 1600 1500 450.5 452 801.25 748.5 0.9\n"), "COLMAP",
                    [](double theta, double phi) {
                      const double r = std::atan(2.0 * std::tan(theta) * std::tan(0.45)) / 0.9;
                      return glm::dvec2{450.5 * r * std::cos(phi) + 800.75, 452.0 * r * std::sin(phi) + 748.0};
                    });
  EXPECT_THAT(refusal_of("1 ODD 1600 1500 450 800 750\n"), HasSubstr("model ODD"));
  EXPECT_THAT(refusal_of("1 OPENCV 1600 1500 450 450 800 750 .1\n"), HasSubstr("5 parameters, expected 8"));
  EXPECT_THAT(refusal_of("1 PINHOLE 9 9 5 5 4 4\n2 PINHOLE 9 9 5 5 4 4\n"), HasSubstr("2 cameras"));
}

// Each is read as if it stood alone, and a file of several is not guessed at.
TEST(ForeignLens, OneOfSeveralCamerasIsChosenByNameOrNumber) {
  const auto camera = [](int number, const std::string& bent, const std::string& d) {
    return fmt::format(
        "cam{0}:\n  cam_overlaps: [{1}]\n  camera_model: pinhole\n  distortion_coeffs: [{2}]\n  distortion_model: {3}\n"
        "  intrinsics: [450.5, 452.0, 801.25, 748.5]\n  resolution: [1600, 1500]\n  rostopic: /eye{0}/image_raw\n"
        "  T_cn_cnm1:\n  - [1.0, 0.0, 0.0, 0.1]\n  - [0.0, 1.0, 0.0, 0.2]\n  timeshift_cam_imu: 0.01\n",
        number, 1 - number, d, bent);
  };
  const auto chain =
      camera(0, "radtan", "-0.05, 0.008, 0.001, -0.0005") + camera(1, "equidistant", "0.02, -0.01, 0.003, -0.0005");
  EXPECT_THAT(refusal_of(chain),
              AllOf(HasSubstr("lens.any: 2 cameras: expected --import-camera with one of "),
                    HasSubstr("cam0 (pinhole-radtan, /eye0/image_raw), cam1 (pinhole-equidistant, /eye1/image_raw)")));
  for (const char* name : {"cam1", "1", "/eye1/image_raw"})
    expect_projection(imported_from(chain, {.camera = name}), "Kalibr", by_opencv_fisheye(0.0));
  expect_projection(imported_from(chain, {.camera = "cam0"}), "Kalibr",
                    by_opencv_pinhole({-0.05, 0.008, 0.001, -0.0005}), {0.0, 30.0, 55.0});
  EXPECT_THAT(refusal_of(chain, {.camera = "2"}), HasSubstr("--import-camera 2: expected one of cam0 (pinhole"));
  EXPECT_THAT(refusal_of(chain + "cam0_extra: 3\n", {.camera = "0"}), HasSubstr("cam0_extra: not a key"));

  const std::string cameras =
      "# Camera list\n1 OPENCV_FISHEYE 1600 1500 450.5 452 801.25 748.5 0.02 -0.01 0.003 -0.0005\n"
      "7 OPENCV 800 600 450.5 452 801.25 748.5 -0.05 0.008 0.001 -0.0005\n";
  EXPECT_THAT(refusal_of(cameras), HasSubstr("one of 1 (OPENCV_FISHEYE, 1600 x 1500), 7 (OPENCV, 800 x 600)"));
  EXPECT_THAT(refusal_of(cameras, {.camera = "2"}), HasSubstr("--import-camera 2: expected one of 1 ("));
  const auto seventh = imported_from(cameras, {.camera = "7"});
  expect_projection(seventh, "COLMAP",
                    [](double theta, double phi) {
                      return by_opencv_pinhole({-0.05, 0.008, 0.001, -0.0005})(theta, phi) - glm::dvec2(0.5);
                    },
                    {0.0, 30.0, 55.0});
  EXPECT_EQ(seventh ? seventh->width : 0, 800);
  EXPECT_THAT(
      refusal_of(kHead + kMatrix + opencv_matrix("distortion_coefficients", {0, 0, 0, 0, 0}, 5), {.camera = "1"}),
      HasSubstr("--import-camera 1: has no effect: the file is of one camera"));
}

TEST(ForeignLens, AgisoftsCalibration) {
  const auto text = [](const std::string& projection, const std::string& more) {
    return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<calibration>\n  <projection>" + projection +
           "</projection>\n  <width>1600</width>\n  <height>1500</height>\n  <f>450</f>\n  <cx>3.5</cx>\n"
           "  <cy>-2.25</cy>\n" +
           more + "  <date>2021-05-06T07:08:09Z</date>\n</calibration>\n";
  };
  // Metashape's manual, appendix D.
  const auto definition = [](double radius, double phi, double b1, double b2, double p1, double p2) {
    const double x = radius * std::cos(phi), y = radius * std::sin(phi), r2 = radius * radius;
    const double radial = 1.0 - 0.04 * r2 + 0.006 * r2 * r2 - 0.0003 * r2 * r2 * r2;
    const double dx = x * radial + p1 * (r2 + 2.0 * x * x) + 2.0 * p2 * x * y,
                 dy = y * radial + p2 * (r2 + 2.0 * y * y) + 2.0 * p1 * x * y;
    return glm::dvec2{800.0 + 3.5 + dx * 450.0 + dx * b1 + dy * b2 - 0.5, 750.0 - 2.25 + dy * 450.0 - 0.5};
  };
  const std::string k = "<k1>-0.04</k1><k2>0.006</k2><k3>-0.0003</k3>\n";
  expect_projection(
      imported_from(text("frame", k + "<b1>2.5</b1><p1>0.001</p1><p2>-0.0007</p2>\n")), "Agisoft",
      [&](double theta, double phi) { return definition(std::tan(theta), phi, 2.5, 0.0, 0.001, -0.0007); },
      {0.0, 30.0, 55.0});
  expect_projection(imported_from(text("fisheye", k + "<b1>2.5</b1><b2>1.5</b2>\n")), "Agisoft",
                    [&](double theta, double phi) { return definition(theta, phi, 2.5, 1.5, 0.0, 0.0); });
  expect_projection(imported_from(text("equisolid_fisheye", k)), "Agisoft", [&](double theta, double phi) {
    return definition(2.0 * std::sin(0.5 * theta), phi, 0.0, 0.0, 0.0, 0.0);
  });
  EXPECT_THAT(refusal_of(text("spherical", "")), HasSubstr("<projection>spherical: expected frame"));
  EXPECT_THAT(refusal_of(text("fisheye", "<s1>0.3</s1>")), HasSubstr("<s1>0.3"));
  EXPECT_THAT(refusal_of(text("fisheye", "<p1>0.05</p1>")), HasSubstr("would move pixels"));
}

TEST(ForeignLens, HuginsProject) {
  const auto text = [](const std::string& picture) {
    return "# hugin project file\np f2 w3000 h1500 v360 n\"TIFF_m\"\nm i0\ni " + picture +
           " Ra0 Rb0 y0 p0 r0 n\"a b.jpg\"\nv a0\n";
  };
  // Panotools: v is the picture's whole width; a b c over half the shorter side.
  const auto definition = [](double (*radius)(double), double view_deg) {
    return [=](double theta, double phi) {
      const double focal = 800.0 / radius(0.5 * view_deg * kPi / 180.0), r = radius(theta) * focal / 750.0;
      const double bent = ((0.01 * r - 0.03) * r + 0.005) * r + 1.0 - 0.01 + 0.03 - 0.005;
      return glm::dvec2{799.5 + 4.0 + 750.0 * r * bent * std::cos(phi), 749.5 - 3.0 + 750.0 * r * bent * std::sin(phi)};
    };
  };
  const std::string bent = " a0.01 b-0.03 c0.005 d4 e-3 g0 t0";
  expect_projection(imported_from(text("w1600 h1500 f3 v195" + bent)), "Hugin",
                    definition([](double angle) { return angle; }, 195.0));
  expect_projection(imported_from(text("w1600 h1500 f21 v190" + bent)), "Hugin",
                    definition([](double angle) { return 2.0 * std::sin(0.5 * angle); }, 190.0));
  expect_projection(imported_from(text("w1600 h1500 f10 v200" + bent)), "Hugin",
                    definition([](double angle) { return 2.0 * std::tan(0.5 * angle); }, 200.0));
  expect_projection(imported_from(text("w1600 h1500 f0 v80" + bent)), "Hugin",
                    definition([](double angle) { return std::tan(angle); }, 80.0), {0.0, 20.0, 35.0});
  EXPECT_THAT(refusal_of(text("w1600 h1500 f4 v360")), HasSubstr("f4: expected 0"));
  EXPECT_THAT(refusal_of(text("w1600 h1500 f3 v180 g5 t0")), HasSubstr("sheared"));
}

TEST(ForeignLens, OcamcalibsIsReadAsItIs) {
  // x = v e + u ..., as OCamCalib's world2cam: the angle of a radius is its polynomial's.
  const auto lens = imported_from(
      "#polynomial\n5 -450 0 5e-4 -2e-7 1e-10\n\n1 0\n\n748.5 801.25\n\n1.001 0.002 -0.001\n\n1500 1600\n");
  expect_projection(lens, "OCamCalib", [](double theta, double phi) {
    double low = 0.0, high = 1200.0;
    for (int i = 0; i < 100; ++i) {
      const double rho = 0.5 * (low + high),
                   z = -450.0 + 5e-4 * rho * rho - 2e-7 * std::pow(rho, 3) + 1e-10 * std::pow(rho, 4);
      (std::atan2(rho, -z) < theta ? low : high) = rho;
    }
    const double u = low * std::cos(phi), v = low * std::sin(phi);
    return glm::dvec2{801.25 + u - 0.001 * v, 748.5 + 0.002 * u + 1.001 * v};
  });
  EXPECT_FALSE(imported_from("5 -450 0 5e-4 -2e-7 1e-10\n", {"pinhole", {}}));
}

TEST(ForeignLens, WhatIsNotKnownOrHasNoEffectIsAnError) {
  const auto d5 = opencv_matrix("D", {-0.05, 0.008, 1e-3, -5e-4, -0.0006}, 5);
  EXPECT_THAT(refusal_of(kHead + kMatrix + d5 + "tilt_deg: 3.5\n"),
              HasSubstr("tilt_deg: a number whose meaning is not known"));
  EXPECT_THAT(refusal_of(kHead + kMatrix + d5 + "nframes: 12\nsquare_size: 25.0\n"), HasSubstr("accepted"));
  EXPECT_THAT(refusal_of(kHead + ("camera_model: \"wonder\"\n" + kMatrix) + d5), HasSubstr("model \"wonder\""));
  EXPECT_THAT(refusal_of(kHead + kSkewed + opencv_matrix("D", {-0.05, 0.008, 0.01, -5e-3, -0.0006}, 5)),
              AllOf(HasSubstr("would move pixels by up to"), HasSubstr("skew")));
  EXPECT_THAT(refusal_of(kHead + kMatrix + opencv_matrix("D", std::vector<double>(14, 0.01), 14)), HasSubstr("tilted"));
  EXPECT_THAT(refusal_of(kHead + kMatrix + d5, {"auto", from_degrees(80.0)}), HasSubstr("no such angle"));
  EXPECT_THAT(refusal_of(kHead + kMatrix + d5, {"opencv_fisheye", {}}), testing::Not(HasSubstr("accepted")));
  EXPECT_THAT(refusal_of("{\"K\": 5}"), HasSubstr("camera_matrix"));
  for (const char* nonsense :
       {"", "a\n", "key: [1, 2", "%YAML:1.0\n---\n", "<calibration><projection>", "i \np \n", "1 A 1 1 1\n"})
    EXPECT_FALSE(imported_from(nonsense)) << nonsense;
}

}  // namespace
}  // namespace kasumi
