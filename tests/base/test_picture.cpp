#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "base/picture.hpp"

namespace kasumi {
namespace {

TEST(Picture, AnRgbImageRoundTripsUnchanged) {
  Image<Rgb8> image(3, 2);
  for (int i = 0; i < 6; ++i) image.at(i % 3, i / 3) = Rgb8(i, 2 * i, 3 * i);
  const auto back = to_rgb(view_of(image));
  EXPECT_EQ(back.elements(), image.elements());
}

TEST(Picture, FullRangePrimariesFollowBt601) {
  // ITU-R BT.601 full range (JFIF): red is Y 76, Cb 85, Cr 255.
  const std::uint8_t y = 76, u = 85, v = 255;
  PictureView p{PixelLayout::i444, YuvEncoding::bt601_full, 1, 1, {Plane{&y, 1}, Plane{&u, 1}, Plane{&v, 1}}};
  const auto rgb = rgb_at(p, 0, 0);
  EXPECT_NEAR(rgb.r, 255, 1);
  EXPECT_NEAR(rgb.g, 0, 1);
  EXPECT_NEAR(rgb.b, 0, 1);
}

TEST(Picture, LimitedRangeBlackAndWhiteAreSixteenAndTwoHundredThirtyFive) {
  for (auto encoding : {YuvEncoding::bt601_limited, YuvEncoding::bt709_limited}) {
    std::uint8_t y = 16, c = 128;
    PictureView p{PixelLayout::i444, encoding, 1, 1, {Plane{&y, 1}, Plane{&c, 1}, Plane{&c, 1}}};
    EXPECT_EQ(rgb_at(p, 0, 0), Rgb8(0));
    y = 235;
    EXPECT_EQ(rgb_at(p, 0, 0), Rgb8(255));
  }
}

TEST(Picture, PackedAndPlanarLayoutsOfTheSameSamplesAgree) {
  const std::vector<std::uint8_t> y{10, 60, 120, 200, 30, 90, 150, 250}, u{100, 140}, v{90, 160};  // 4 x 2, 4:2:0
  const std::vector<std::uint8_t> uv{100, 90, 140, 160};
  std::vector<std::uint8_t> yuyv, uyvy;
  for (std::size_t row = 0; row < 2; ++row)
    for (std::size_t pair = 0; pair < 2; ++pair) {
      const auto y0 = y[row * 4 + pair * 2], y1 = y[row * 4 + pair * 2 + 1];
      yuyv.insert(yuyv.end(), {y0, u[pair], y1, v[pair]});
      uyvy.insert(uyvy.end(), {u[pair], y0, v[pair], y1});
    }
  const auto e = YuvEncoding::bt601_limited;
  const auto i420 = to_rgb({PixelLayout::i420, e, 4, 2, {Plane{y.data(), 4}, Plane{u.data(), 2}, Plane{v.data(), 2}}});
  EXPECT_EQ(to_rgb({PixelLayout::nv12, e, 4, 2, {Plane{y.data(), 4}, Plane{uv.data(), 4}, Plane{}}}).elements(),
            i420.elements());
  EXPECT_EQ(to_rgb({PixelLayout::yuyv, e, 4, 2, {Plane{yuyv.data(), 8}, Plane{}, Plane{}}}).elements(),
            i420.elements());
  EXPECT_EQ(to_rgb({PixelLayout::uyvy, e, 4, 2, {Plane{uyvy.data(), 8}, Plane{}, Plane{}}}).elements(),
            i420.elements());
}

TEST(Picture, ACopyOutlivesWhatItIsOf) {
  for (const auto layout : {PixelLayout::rgb8, PixelLayout::yuyv, PixelLayout::nv12, PixelLayout::i420}) {
    constexpr int kWidth = 6, kHeight = 5;
    constexpr std::size_t kStride = 32;  // wider than a row
    std::vector<std::uint8_t> bytes(3 * kStride * kHeight);
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(37 * i);
    PictureView view{layout, YuvEncoding::bt601_full, kWidth, kHeight, {}};
    for (std::size_t i = 0; i < static_cast<std::size_t>(plane_count(layout)); ++i)
      view.planes[i] = {bytes.data() + i * kStride * kHeight, kStride};
    const auto seen = to_rgb(view);
    std::optional<CopiedPicture> first(view);
    const CopiedPicture copy = *first;
    first.reset();
    std::ranges::fill(bytes, std::uint8_t{0});
    EXPECT_EQ(to_rgb(copy.view()).elements(), seen.elements()) << name_of(layout);
  }
}

TEST(Picture, ChromaPlanesOfOddSizesAreRoundedUp) {
  EXPECT_EQ(plane_size(PixelLayout::nv12, 5, 3, 1).row_bytes, 6u);
  EXPECT_EQ(plane_size(PixelLayout::i420, 5, 3, 2).rows, 2);
  EXPECT_EQ(plane_size(PixelLayout::yuyv, 5, 3, 0).row_bytes, 12u);
}

}  // namespace
}  // namespace kasumi
