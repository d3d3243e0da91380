// What of a picture outlasts the blur, against the Gaussian's closed form; and that no face does.
#include <cmath>
#include <cstdlib>
#include <random>

#include <gtest/gtest.h>

#include "pipeline/kiosk/snapshot/blurred_picture.hpp"
#include "tests/picture_difference.hpp"

namespace kasumi {
namespace {

constexpr int kWidth = 1920, kHeight = 1080;
constexpr double kCell_px = static_cast<double>(kWidth) / kBlurredPixels;

// Upright stripes of full contrast, as a sine.
Image<Rgb8> stripes(double period_px, double phase) {
  Image<Rgb8> picture(kWidth, 200);
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < kWidth; ++x)
      picture.at(x, y) =
          Rgb8(static_cast<std::uint8_t>(std::lround(127.5 + 127.5 * std::sin(2 * M_PI * x / period_px + phase))));
  return picture;
}

// Of full contrast, away from the picture's edges.
double contrast_left(double period_cells, double phase) {
  const auto blurred = blurred_beyond_recognition(stripes(period_cells * kCell_px, phase));
  int lowest = 255, highest = 0;
  for (int x = 4; x < blurred.width() - 4; ++x) {
    lowest = std::min<int>(lowest, blurred.at(x, 1).g);
    highest = std::max<int>(highest, blurred.at(x, 1).g);
  }
  return (highest - lowest) / 255.0;
}

TEST(BlurredPicture, HasThirtyTwoPixelsAlongItsLongerSide) {
  for (const auto& [width, height, across, down] :
       {std::array{1920, 1080, 32, 18}, {640, 360, 32, 18}, {1080, 1920, 18, 32}, {3840, 40, 32, 1}, {7, 5, 32, 23}}) {
    const auto blurred = blurred_beyond_recognition(Image<Rgb8>(width, height, Rgb8(10, 128, 250)));
    EXPECT_EQ(blurred.width(), across);
    EXPECT_EQ(blurred.height(), down);
    for (const Rgb8& pixel : blurred.elements()) EXPECT_EQ(pixel, Rgb8(10, 128, 250)) << "of one colour it stays so";
  }
  EXPECT_TRUE(blurred_beyond_recognition({}).empty());
}

TEST(BlurredPicture, LosesWhatIsCloseTogether) {
  for (const double phase : {0.0, 0.7, 1.4}) {
    for (const double period : {0.1, 0.5, 1.0, 1.5, 2.0})
      EXPECT_LE(contrast_left(period, phase), 3.0 / 255.0) << period;
    EXPECT_LE(contrast_left(4.0, phase), std::exp(-2.0 * std::pow(M_PI / 4.0, 2)) + 0.01) << "three tenths";
  }
  EXPECT_GE(contrast_left(16.0, 0.0), 0.85) << "where sky, land and building are stays to be seen";
}

// Two heads of the same mean colour, each two cells high, at any place: as good as the same.
TEST(BlurredPicture, TellsNoFaceFromAnother) {
  std::mt19937 random(5);
  const auto face = [&](Image<Rgb8>& picture, int left, int top) {
    constexpr int kFeature_px = 12, kAcross = 8, kDown = 10;
    std::vector<std::uint8_t> features(kAcross * kDown);
    for (std::size_t i = 0; i < features.size(); ++i) features[i] = i % 2 == 0 ? 40 : 220;
    std::shuffle(features.begin(), features.end(), random);
    for (int y = 0; y < kDown * kFeature_px; ++y)
      for (int x = 0; x < kAcross * kFeature_px; ++x)
        picture.at(left + x, top + y) =
            Rgb8(features[static_cast<std::size_t>(y / kFeature_px * kAcross + x / kFeature_px)]);
  };
  int largest = 0;
  for (int trial = 0; trial < 10; ++trial) {
    Image<Rgb8> one(kWidth, kHeight, Rgb8(130)), other = one;
    face(one, 700 + 7 * trial, 400 + 11 * trial);
    face(other, 700 + 7 * trial, 400 + 11 * trial);
    ASSERT_GE(difference(one, other).largest, 180);
    largest = std::max(largest, difference(blurred_beyond_recognition(one), blurred_beyond_recognition(other)).largest);
  }
  std::printf("two faces of 96 x 120 of 1920 x 1080 pixels differ by %d of 255 at most\n", largest);
  EXPECT_LE(largest, 10);
}

}  // namespace
}  // namespace kasumi
