// Errors of pixels against closed forms, and masks.
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "base/colour_difference.hpp"
#include "pipeline/lab/comparison/pixel_errors.hpp"

namespace kasumi {
namespace {

using Picture = Image<glm::vec3>;

Picture random_picture(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> value(0.0F, 1.0F);
  Picture picture(60, 40);
  for (auto& pixel : picture.elements()) pixel = {value(random), value(random), value(random)};
  return picture;
}

TEST(PixelErrors, OfAShiftByOneStepAreThatStep) {
  const Picture one(20, 10, glm::vec3(100.0F / 255.0F)), other(20, 10, glm::vec3(101.0F / 255.0F));
  const auto errors = pixel_errors(one, other, {});
  EXPECT_EQ(errors.pixels, 200u);
  EXPECT_NEAR(errors.mean_absolute, 1.0, 1e-4);
  EXPECT_NEAR(errors.psnr_db.value(), 20.0 * std::log10(255.0), 1e-3) << "48.13 dB";
}

TEST(PixelErrors, OfBlackAndWhiteAreTheLargestThereAre) {
  const auto errors = pixel_errors(Picture(20, 10, glm::vec3(0.0F)), Picture(20, 10, glm::vec3(1.0F)), {});
  EXPECT_NEAR(errors.mean_absolute, 255.0, 1e-9);
  EXPECT_NEAR(errors.psnr_db.value(), 0.0, 1e-9);
  EXPECT_NEAR(errors.ciede2000.mean, 100.0, 1e-2) << "L from 0 to 100 weighs 1 where its mean is 50";
}

TEST(PixelErrors, OfEqualPicturesAreNone) {
  const auto picture = random_picture(1);
  const auto errors = pixel_errors(picture, picture, {});
  EXPECT_FALSE(errors.psnr_db);
  EXPECT_EQ(errors.mean_absolute, 0.0);
  EXPECT_EQ(errors.ciede2000.largest, 0.0);
}

// sRGB's red and green have published CIELAB values (53.24, 80.09, 67.20) and (87.73, -86.18, 83.18).
TEST(PixelErrors, ColoursAreSrgbUnderD65) {
  const auto errors = pixel_errors(Picture(4, 4, {1.0F, 0.0F, 0.0F}), Picture(4, 4, {0.0F, 1.0F, 0.0F}), {});
  EXPECT_NEAR(errors.ciede2000.mean, ciede2000({53.24, 80.09, 67.20}, {87.73, -86.18, 83.18}), 0.02);
}

TEST(PixelErrors, TheShareThatDiffersIsSeenAtTheTop) {
  Picture one(10, 10, glm::vec3(0.5F)), other = one;
  for (int x = 0; x < 4; ++x) other.at(x, 0) = glm::vec3(0.6F);
  auto errors = pixel_errors(one, other, {});
  EXPECT_EQ(errors.ciede2000.at_95_percent, 0.0) << "4 of 100 differ";
  EXPECT_GT(errors.ciede2000.largest, 5.0);
  for (int x = 0; x < 7; ++x) other.at(x, 0) = glm::vec3(0.6F);
  errors = pixel_errors(one, other, {});
  EXPECT_EQ(errors.ciede2000.at_95_percent, errors.ciede2000.largest) << "7 of 100 differ";
}

TEST(ComparisonMask, WhatItHidesPlaysNoRoleInAnyMeasure) {
  const auto one = random_picture(2);
  auto other = one;
  CountedPixels counted(60, 40, 255);
  const auto strange = random_picture(3);
  for (int y = 10; y < 30; ++y)
    for (int x = 0; x < 25; ++x) {
      other.at(x, y) = strange.at(x, y);
      counted.at(x, y) = 0;
    }
  EXPECT_LT(ssim(one, other, {}).value(), 0.9);
  EXPECT_NEAR(ssim(one, other, counted).value(), 1.0, 1e-9) << "no window may reach into what is hidden";
  EXPECT_LT(hsv_correlation(one, other, {}).combined(), 0.999);
  EXPECT_NEAR(hsv_correlation(one, other, counted).combined(), 1.0, 1e-9);
  const auto errors = pixel_errors(one, other, counted);
  EXPECT_EQ(errors.pixels, 60u * 40u - 20u * 25u);
  EXPECT_FALSE(errors.psnr_db);
}

TEST(ComparisonMask, WithoutAWholeWindowThereIsNoStructure) {
  const auto one = random_picture(4), other = random_picture(5);
  CountedPixels counted(60, 40, 0);
  for (int y = 0; y < 10; ++y)
    for (int x = 0; x < 10; ++x) counted.at(x, y) = 255;
  EXPECT_FALSE(ssim(one, other, counted));
  EXPECT_FALSE(ssim(Picture(10, 40), Picture(10, 40), {}));
  for (int i = 0; i < 11; ++i) counted.at(10, i) = counted.at(i, 10) = 255;
  EXPECT_TRUE(ssim(one, other, counted)) << "11 x 11 are one window";
}

TEST(ComparisonMask, FineValuesGiveWhatBytesGive) {
  Image<Rgb8> one(40, 30), other(40, 30);
  Picture fine_one(40, 30), fine_other(40, 30);
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x) {
      one.at(x, y) = Rgb8(6 * x, 8 * y, 3 * x + y);
      other.at(x, y) = Rgb8(5 * x, 7 * y, (x * y) % 256);
      fine_one.at(x, y) = glm::vec3(one.at(x, y)) / 255.0F;
      fine_other.at(x, y) = glm::vec3(other.at(x, y)) / 255.0F;
    }
  EXPECT_NEAR(ssim(fine_one, fine_other, {}).value(), ssim(one, other), 1e-6);
  EXPECT_EQ(hsv_correlation(fine_one, fine_other, {}).combined(), hsv_correlation(one, other).combined());
}

}  // namespace
}  // namespace kasumi
