#include <filesystem>
#include <functional>
#include <random>
#include <string>

#include <opencv2/imgcodecs.hpp>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "base/result.hpp"
#include "base/units.hpp"
#include "calib/mask/image_circle.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

namespace fs = std::filesystem;
const fs::path kData(shared_data_folder());

// A sky with a bright sun inside a dark surround, anti-aliased at the rim, with noise everywhere.
struct Disc {
  int width = 400;
  int height = 400;
  glm::dvec2 centre{203.4, 196.7};
  double radius_px = 180.0;
  double sky = 90.0;
  double surround = 3.0;
  double noise = 2.0;
  // Transmitted fraction of the sky's light by azimuth and radius (1 at the rim).
  std::function<double(double, double)> open = [](double, double) { return 1.0; };
};

Image<Rgb8> drawn(const Disc& disc) {
  std::mt19937_64 random(7);
  const auto noise = [&] {  // nearly normal: a sum of twelve uniform numbers
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += static_cast<double>(random() >> 11) * 0x1p-53;
    return disc.noise * sum;
  };
  Image<Rgb8> picture(disc.width, disc.height);
  for (int y = 0; y < disc.height; ++y)
    for (int x = 0; x < disc.width; ++x) {
      const glm::dvec2 offset = glm::dvec2{x, y} - disc.centre;
      const double r = glm::length(offset), azimuth = std::atan2(offset.y, offset.x);
      const double inside = std::clamp(disc.radius_px - r + 0.5, 0.0, 1.0);
      const double sun = 160.0 * std::exp(-glm::dot(offset - 50.0, offset - 50.0) / 800.0);
      const double light = (disc.sky + sun) * disc.open(azimuth, r / disc.radius_px);
      Rgb8& pixel = picture.at(x, y);
      for (int c = 0; c < 3; ++c) {
        const double value = disc.surround + inside * light * (0.7 + 0.15 * c) + noise();
        pixel[c] = static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
      }
    }
  return picture;
}

void expect_found(const Disc& disc, const char* what) {
  const auto circle = find_image_circle(drawn(disc));
  ASSERT_TRUE(circle) << what;
  EXPECT_NEAR(circle->radius_px, disc.radius_px, 0.01 * disc.radius_px) << what;
  EXPECT_LE(glm::distance(circle->centre, disc.centre), 0.01 * disc.radius_px) << what;
}

TEST(ImageCircle, ADiscOnADarkSurroundIsFoundWithinOnePercent) {
  expect_found({}, "as it is");
  Disc noisy;
  noisy.noise = 6.0;
  noisy.surround = 12.0;
  expect_found(noisy, "noisy");
  Disc clean;
  clean.noise = 0.0;
  clean.surround = 0.0;
  clean.sky = 8.0;
  expect_found(clean, "underexposed");
  Disc small;
  small.radius_px = 60.0;
  small.centre = {120.2, 280.9};
  expect_found(small, "small and off-centre");
}

TEST(ImageCircle, TreesAndBuildingsOnTheHorizonDoNotShrinkIt) {
  Disc disc;
  disc.open = [](double azimuth, double r) {
    const double trees = 0.85 + 0.12 * std::sin(7.0 * azimuth) * std::sin(23.0 * azimuth + 1.0);
    const bool building = azimuth > 0.4 && azimuth < 1.1 && r > 0.6;
    return building || (azimuth < 0.0 && azimuth > -2.2 && r > trees) ? 0.0 : 1.0;
  };
  expect_found(disc, "buildings and trees");
}

TEST(ImageCircle, ARimHalfInDarknessIsEnough) {
  Disc disc;
  disc.open = [](double azimuth, double r) { return r > 0.8 && azimuth > -0.9 && azimuth < 2.3 ? 0.0 : 1.0; };
  expect_found(disc, "half dark");
}

TEST(ImageCircle, ACircleCutByTheImageBorderIsFound) {
  Disc disc;
  disc.width = 500;
  disc.height = 320;
  disc.centre = {247.8, 158.2};
  disc.radius_px = 190.0;
  expect_found(disc, "cut above and below");
}

TEST(ImageCircle, ALensFlareOutsideTheCircleIsNotMistakenForIt) {
  auto picture = drawn({});
  for (int y = 10; y < 30; ++y)
    for (int x = 340; x < 380; ++x) picture.at(x, y) = Rgb8{200, 200, 180};
  const auto circle = find_image_circle(picture);
  ASSERT_TRUE(circle);
  EXPECT_NEAR(circle->radius_px, 180.0, 1.8);
}

TEST(ImageCircle, ALargePicturesCircleIsFoundWithinOnePercent) {
  Disc disc;
  disc.width = 2000;
  disc.height = 1600;
  disc.centre = {1010.6, 795.1};
  disc.radius_px = 760.0;
  expect_found(disc, "large");
}

TEST(ImageCircle, ThereIsNoneInPicturesWithoutOne) {
  EXPECT_FALSE(find_image_circle({}));
  EXPECT_FALSE(find_image_circle(Image<Rgb8>(4, 4)));
  EXPECT_FALSE(find_image_circle(Image<Rgb8>(300, 200))) << "black";
  EXPECT_FALSE(find_image_circle(Image<Rgb8>(300, 200, Rgb8{120, 140, 160}))) << "grey";

  Image<Rgb8> rectangle(300, 300), landscape(300, 200), gradient(300, 200);
  for (int y = 0; y < 300; ++y)
    for (int x = 0; x < 300; ++x) {
      if (x > 60 && x < 240 && y > 70 && y < 235) rectangle.at(x, y) = Rgb8{150, 150, 150};
      if (y >= 200) continue;
      const double hills = 110.0 + 20.0 * std::sin(x / 30.0);
      landscape.at(x, y) = y < hills ? Rgb8{120, 150, 200} : Rgb8{5, 6, 4};
      gradient.at(x, y) = Rgb8(glm::u8vec3(static_cast<std::uint8_t>(x * 255 / 300)));
    }
  EXPECT_FALSE(find_image_circle(rectangle)) << "a rectangle";
  EXPECT_FALSE(find_image_circle(landscape)) << "a landscape";
  EXPECT_FALSE(find_image_circle(gradient)) << "a gradient";

  Disc dark;  // noise only
  dark.sky = 0.0;
  dark.open = [](double, double) { return 0.0; };
  EXPECT_FALSE(find_image_circle(drawn(dark))) << "noise";
}

Image<Rgb8> loaded(const fs::path& path) {
  const cv::Mat bgr = cv::imread(path.string(), cv::IMREAD_COLOR);
  Image<Rgb8> picture(bgr.cols, bgr.rows);
  for (int y = 0; y < bgr.rows; ++y)
    for (int x = 0; x < bgr.cols; ++x) {
      const auto& pixel = bgr.at<cv::Vec3b>(y, x);
      picture.at(x, y) = {pixel[2], pixel[1], pixel[0]};
    }
  return picture;
}

TEST(ImageCircle, ARealFisheyesCircleIsFoundWithinThreePixels) {
  const auto folder = kData / "sky/skycam-alpnach";
  if (!fs::exists(folder)) GTEST_SKIP() << "no sky pictures at " << folder;
  int found = 0;
  for (int exposure = 0; exposure < 13; ++exposure) {
    const auto name = fmt::format("Alpnach_20180129_11-09-20_ExposureStack_Image_{:02}_image.png", exposure);
    const auto circle = find_image_circle(loaded(folder / name));
    if (!circle) continue;
    ++found;
    std::printf("exposure %d: centre (%.2f, %.2f), radius %.2f px, sigma %.2f\n", exposure, circle->centre.x,
                circle->centre.y, circle->radius_px, circle->sigma_px);
    EXPECT_NEAR(circle->centre.x, 149.6, 3.0) << exposure;
    EXPECT_NEAR(circle->centre.y, 140.7, 3.0) << exposure;
    EXPECT_NEAR(circle->radius_px, 133.0, 3.0) << exposure;
  }
  EXPECT_GE(found, 3) << "of the brighter ones";
}

TEST(ImageCircle, ThereIsNoneInPhotographs) {
  const auto folder = kData / "haze";
  if (!fs::exists(folder)) GTEST_SKIP() << "no photographs at " << folder;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const auto extension = entry.path().extension();
    if (extension != ".png" && extension != ".jpg") continue;
    EXPECT_FALSE(find_image_circle(loaded(entry.path()))) << entry.path();
  }
}

}  // namespace
}  // namespace kasumi
