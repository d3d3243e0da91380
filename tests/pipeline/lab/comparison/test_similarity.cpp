// The similarity measures against closed forms of Wang 2004 and Pearson.
#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/lab/comparison/similarity.hpp"

namespace kasumi {
namespace {

Image<Rgb8> grey(int width, int height, auto value) {
  Image<Rgb8> picture(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) picture.at(x, y) = Rgb8(static_cast<std::uint8_t>(value(x, y)));
  return picture;
}

TEST(Ssim, IsOneForIdenticalPictures) {
  const auto picture = grey(40, 30, [](int x, int y) { return (7 * x + 13 * y * y) % 256; });
  EXPECT_NEAR(ssim(picture, picture), 1.0, 1e-9);
}

TEST(Ssim, OfFlatPicturesIsItsLuminanceTerm) {
  constexpr double kC1 = 0.01 * 255 * 0.01 * 255;
  const auto dark = grey(20, 20, [](int, int) { return 60; }), bright = grey(20, 20, [](int, int) { return 140; });
  EXPECT_NEAR(ssim(dark, bright), (2.0 * 60 * 140 + kC1) / (60.0 * 60 + 140.0 * 140 + kC1), 1e-6);
}

// Stripes of one pixel: the window's weights on even and odd columns are nearly equal, so that the mean is 128 and the
// deviation the amplitude; at half the contrast the covariance is 800, the variances 1600 and 400.
TEST(Ssim, OfStripesOfHalfTheContrastIsItsContrastTerm) {
  constexpr double kC2 = 0.03 * 255 * 0.03 * 255;
  const auto strong = grey(40, 40, [](int x, int) { return x % 2 == 0 ? 168 : 88; });
  const auto weak = grey(40, 40, [](int x, int) { return x % 2 == 0 ? 148 : 108; });
  const auto opposite = grey(40, 40, [](int x, int) { return x % 2 == 0 ? 88 : 168; });
  EXPECT_NEAR(ssim(strong, weak), (2.0 * 800 + kC2) / (1600.0 + 400.0 + kC2), 1e-3);
  EXPECT_NEAR(ssim(strong, opposite), (-2.0 * 1600 + kC2) / (2.0 * 1600 + kC2), 2e-3);
}

TEST(HsvCorrelation, IsOneForTheSameColoursInOtherPlaces) {
  Image<Rgb8> one(60, 40), mirrored(60, 40);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 60; ++x)
      mirrored.at(59 - x, y) = one.at(x, y) = Rgb8(4 * x, 6 * y, static_cast<std::uint8_t>(7 * x * y));
  const auto found = hsv_correlation(one, mirrored);
  EXPECT_NEAR(found.hue, 1.0, 1e-9);
  EXPECT_NEAR(found.saturation, 1.0, 1e-9);
  EXPECT_NEAR(found.value, 1.0, 1e-9);
  EXPECT_NEAR(found.combined(), 1.0, 1e-9);
}

// All pixels in one bin of n, in the other picture all in another: Pearson gives -1 / (n - 1).
TEST(HsvCorrelation, OfTwoSingleColoursIsThatOfTwoOccupiedBins) {
  const Image<Rgb8> red(16, 16, Rgb8(200, 0, 0)), green(16, 16, Rgb8(0, 100, 0));
  const auto found = hsv_correlation(red, green);
  EXPECT_NEAR(found.hue, -1.0 / 29.0, 1e-6);
  EXPECT_NEAR(found.saturation, 1.0, 1e-9) << "both are pure colours";
  EXPECT_NEAR(found.value, -1.0 / 31.0, 1e-6);
}

}  // namespace
}  // namespace kasumi
