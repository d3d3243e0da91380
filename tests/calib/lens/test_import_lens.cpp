#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "calib/lens/import_lens.hpp"
#include "tests/must.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

std::filesystem::path import_file(const std::string& name, const std::string& text) {
  const auto folder = test_output_folder() / "import";
  std::filesystem::create_directories(folder);
  EXPECT_TRUE(write_text_file(folder / name, text));
  return folder / name;
}

std::string matrix(const std::string& name, int rows, int columns, const std::string& data) {
  return fmt::format("{}: !!opencv-matrix\n   rows: {}\n   cols: {}\n   dt: d\n   data: [ {} ]\n", name, rows, columns,
                     data);
}

// As OpenCV's camera_calibration sample writes it.
TEST(ImportLens, OpencvYamlIsReadWithItsModel) {
  const auto head = std::string("%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\n");
  const auto camera = matrix("camera_matrix", 3, 3, "500.5, 0., 319.25, 0., 501.5, 240.75, 0., 0., 1.");
  const auto plain = must(import_lens(import_file(
      "brown.yml", head + camera + matrix("distortion_coefficients", 5, 1, "-0.2, 0.05, 1e-3, -2e-3, 0.01") +
                       "avg_reprojection_error: 0.25\n")));
  const auto& brown = std::get<PinholeParameters>(plain->lens.model);
  EXPECT_EQ(brown.focal_px, glm::dvec2(500.5, 501.5));
  EXPECT_EQ(brown.centre, glm::dvec2(319.25, 240.75));
  EXPECT_EQ(brown.distortion, (std::array{-0.2, 0.05, 1e-3, -2e-3, 0.01}));
  EXPECT_EQ(plain->width, 640);
  EXPECT_EQ(plain->height, 480);
  EXPECT_EQ(plain->rms_px, 0.25);

  const auto fisheye = must(import_lens(import_file(
      "fisheye.yml",
      head + "fisheye_model: 1\n" + camera + matrix("distortion_coefficients", 4, 1, "-0.01, 0.02, -0.007, 0.001"))));
  EXPECT_EQ(std::get<OpencvFisheyeParameters>(fisheye->lens.model).k, (std::array{-0.01, 0.02, -0.007, 0.001}));
}

TEST(ImportLens, OpencvXmlIsReadAsWell) {
  const auto lens = must(import_lens(import_file(
      "k.xml",
      "<?xml version=\"1.0\"?>\n<opencv_storage>\n<image_width>800</image_width>\n<image_height>600</image_height>\n"
      "<K type_id=\"opencv-matrix\"><rows>3</rows><cols>3</cols><dt>d</dt><data>400. 0. 400. 0. 401. 300. 0. 0. 1."
      "</data></K>\n<D type_id=\"opencv-matrix\"><rows>1</rows><cols>5</cols><dt>d</dt><data>0.1 0. 0. 0. "
      "0.</data></D>\n"
      "</opencv_storage>\n")));
  EXPECT_EQ(std::get<PinholeParameters>(lens->lens.model).focal_px, glm::dvec2(400.0, 401.0));
}

TEST(ImportLens, ReportsAllProblemsAtOnce) {
  const auto broken = import_lens(
      import_file("broken.yml", "%YAML:1.0\n---\n" + matrix("camera_matrix", 2, 2, "1., 0., 0., 1.") +
                                    matrix("distortion_coefficients", 8, 1, "1., 2., 3., 4., 5., 6., 7., 8.")));
  ASSERT_FALSE(broken);
  EXPECT_EQ(broken.error().kind, FaultKind::bad_input);
  for (const char* part : {"camera_matrix", "image_width"}) EXPECT_THAT(broken.error().message, HasSubstr(part));
  EXPECT_FALSE(import_lens(import_file("text.yml", "this is no calibration")));
  EXPECT_FALSE(import_lens(import_file("empty.xml", "")));
  EXPECT_FALSE(import_lens("/nowhere/at-all.yml"));
}

TEST(ImportLens, OcamcalibTextIsRecognised) {
  const auto path = import_file("ocam.txt", "3 -100.0 0.0 1e-003\n1 5\n 40.5 60.25\n1.01 0.02 0.03\n80 120\n");
  const auto lens = must(import_lens(path));
  EXPECT_EQ(lens->program, "OCamCalib");
  EXPECT_EQ(lens->width, 120);
  EXPECT_EQ(centre_of(lens->lens), glm::dvec2(60.25, 40.5));
}

}  // namespace
}  // namespace kasumi
