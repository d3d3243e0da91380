#include <filesystem>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "base/files.hpp"
#include "base/geometry.hpp"
#include "calib/lens/lens.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

const std::filesystem::path kSample = shared_data_folder() / "fisheye/ocam-sample";

std::filesystem::path ocam_file(const std::string& name, const std::string& text) {
  const auto folder = test_output_folder() / "calib";
  std::filesystem::create_directories(folder);
  EXPECT_TRUE(write_text_file(folder / name, text));
  return folder / name;
}

TEST(Ocamcalib, RowAndColumnBecomeYAndX) {
  const auto path = ocam_file("ocam.txt", "# c\n3 -100.0 0.0 1e-003\n\n1 5\n\n 40.5 60.25\n1.01 0.02 0.03\n80 120\n");
  const auto model = read_ocamcalib(path);
  ASSERT_TRUE(model) << model.error().message;
  EXPECT_EQ(model->polynomial, (std::vector{-100.0, 0.0, 1e-3}));
  EXPECT_EQ(model->centre, glm::dvec2(60.25, 40.5));
  EXPECT_EQ(model->width, 120);
  EXPECT_EQ(model->height, 80);

  // OCamCalib: (row, column) = [c d; e 1] (x', y') + centre, with the ray (x', y', a0 + a2 rho^2), z pointing into the
  // camera.
  const auto lens = scaramuzza_lens(*model, from_degrees(90.0));
  const double x = 10.0, y = -20.0;
  const auto ray = lens->unproject({60.25 + 0.03 * x + y, 40.5 + 1.01 * x + 0.02 * y}).value();
  const auto expected = glm::normalize(glm::dvec3{y, x, 100.0 - 1e-3 * 500.0});
  EXPECT_LE(angle_between(ray, expected).value, 1e-12);
}

TEST(Ocamcalib, ABrokenFileIsRefusedWithAllItsProblems) {
  const auto model = read_ocamcalib(ocam_file("broken.txt", "3 100.0 0.0 1e-3\n1 5\n 40.5\n0 1 1\n80 banana\n"));
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().kind, FaultKind::bad_input);
  for (const char* part : {"broken.txt: line 5: \"banana\"", "a0 = 100: expected a number < 0", "centre: expected two",
                           "c - d e > 0", "image size"})
    EXPECT_THAT(model.error().message, HasSubstr(part));
  EXPECT_FALSE(read_ocamcalib(ocam_file("empty.txt", "")));
  EXPECT_FALSE(read_ocamcalib("/nowhere/calib.txt"));
}

// The published inverse polynomial was fitted by other software: our inverse must agree within that fit's accuracy.
TEST(Ocamcalib, ProjectionAgreesWithThePublishedInversePolynomial) {
  if (!std::filesystem::exists(kSample)) GTEST_SKIP() << "no sample data at " << kSample;
  const auto model = read_ocamcalib(kSample / "calib_results_fisheye.txt").value();
  const auto lens = scaramuzza_lens(model, from_degrees(90.0));
  const std::vector<double> inverse{730.949123,  315.876984,  -177.960849, -352.468231,
                                    -678.144608, -615.917273, -262.086205, -42.961956};
  for (double off = 5.0; off <= 80.0; off += 5.0) {
    const double elevation = from_degrees(off - 90.0).value;  // OCamCalib's theta: from the sensor plane, z backwards
    double rho = 0.0;
    for (std::size_t i = inverse.size(); i-- > 0;) rho = rho * elevation + inverse[i];
    const auto angle = from_degrees(off).value;
    const auto pixel = lens->project({std::sin(angle), 0.0, std::cos(angle)}).value();
    EXPECT_NEAR(pixel.x - model.centre.x, rho, 0.6) << off;
  }
}

// RMS distance in pixels of points from the image of the best-fitting straight line in space.
double straightness_px(const Lens& lens, const std::vector<cv::Point2f>& points) {
  cv::Mat rays(0, 3, CV_64F);
  for (const auto& point : points) {
    const auto ray = lens.unproject({point.x, point.y}).value();
    rays.push_back(cv::Mat(cv::Matx13d(ray.x, ray.y, ray.z)));
  }
  const cv::SVD svd(rays, cv::SVD::FULL_UV);
  const glm::dvec3 normal{svd.vt.at<double>(2, 0), svd.vt.at<double>(2, 1), svd.vt.at<double>(2, 2)};
  double sum = 0.0;
  for (const auto& point : points) {
    const auto ray = lens.unproject({point.x, point.y}).value();
    const auto nearest = lens.project(ray - glm::dot(ray, normal) * normal).value();
    sum += std::pow(glm::distance(nearest, {point.x, point.y}), 2.0);
  }
  return std::sqrt(sum / static_cast<double>(points.size()));
}

double board_straightness_px(const Lens& lens, const std::vector<cv::Point2f>& corners, cv::Size board) {
  double sum = 0.0;
  int lines = 0;
  const auto add_line = [&](int first, int step, int count) {
    std::vector<cv::Point2f> line;
    for (int i = 0; i < count; ++i) line.push_back(corners[first + i * step]);
    sum += std::pow(straightness_px(lens, line), 2.0);
    ++lines;
  };
  for (int row = 0; row < board.height; ++row) add_line(row * board.width, 1, board.width);
  for (int column = 0; column < board.width; ++column) add_line(column, board.width, board.height);
  return std::sqrt(sum / lines);
}

TEST(Ocamcalib, CheckerboardLinesAreStraightWithThePublishedIntrinsics) {
  if (!std::filesystem::exists(kSample)) GTEST_SKIP() << "no sample data at " << kSample;
  const auto picture = cv::imread((kSample / "test_fisheye.jpg").string(), cv::IMREAD_GRAYSCALE);
  ASSERT_FALSE(picture.empty());
  const cv::Size board(5, 8);
  std::vector<cv::Point2f> corners;
  ASSERT_TRUE(cv::findChessboardCornersSB(picture, board, corners, cv::CALIB_CB_ACCURACY | cv::CALIB_CB_EXHAUSTIVE));

  const auto model = read_ocamcalib(kSample / "calib_results_fisheye.txt").value();
  const double published = board_straightness_px(*scaramuzza_lens(model, from_degrees(100.0)), corners, board);
  const auto undistorted = pinhole_lens({{551.8, 551.8}, model.centre, {}});
  const double without = board_straightness_px(*undistorted, corners, board);
  RecordProperty("published_px", std::to_string(published));
  RecordProperty("without_px", std::to_string(without));
  std::printf("straightness: %.3f px with the published intrinsics, %.3f px without\n", published, without);
  EXPECT_LE(published, 0.25);
  EXPECT_GE(without, 2.0);

  auto swapped = model;
  std::swap(swapped.centre.x, swapped.centre.y);
  EXPECT_GE(board_straightness_px(*scaramuzza_lens(swapped, from_degrees(100.0)), corners, board), 2.0 * published);
}

}  // namespace
}  // namespace kasumi
