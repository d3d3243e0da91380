// Response tables and mipmaps as uploaded to the GPU.
#include <cmath>

#include <gtest/gtest.h>

#include "gles/gl/surface_texture.hpp"
#include "gles/picture/response_table.hpp"
#include "tests/gles/object/reference_renderer.hpp"

namespace kasumi {
namespace {

// The interpolation of response.glsl, on the CPU.
double in_table(const Image<glm::u8vec4>& texels, double at, int row) {
  const double place = at * (kResponseEntries - 1);
  const int entry = std::min(static_cast<int>(place), kResponseEntries - 2);
  const glm::u8vec4 t = texels.at(entry, row);
  const double low = (t.r * 256 + t.g) / 65535.0, high = (t.b * 256 + t.a) / 65535.0;
  return low + (place - entry) * (high - low);
}

ResponseCurve table_of(double (*light)(double), int entries) {
  ResponseCurve curve{ResponseCurve::Kind::table, {}};
  for (auto& channel : curve.light)
    for (int i = 0; i < entries; ++i) channel.push_back(light(static_cast<double>(i) / (entries - 1)));
  return curve;
}

TEST(ResponseTable, RoundTripsWithinATwentiethOfAStep) {
  const std::array<double (*)(double), 4> curves{
      [](double x) { return x; }, [](double x) { return std::pow(x, 2.2); },
      [](double x) { return (std::exp(3 * x) - 1) / (std::exp(3.0) - 1); },
      [](double x) { return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4); }};
  for (const auto& light : curves)
    for (const int entries : {2, 256, 1024}) {
      const ResponseCurve curve = table_of(light, entries);
      const auto texels = response_texels(curve);
      // The darkest codes of a power law differ by less than 16 bits resolve; they are accurate from code 2 on.
      for (int code = 2; code <= 255; ++code) {
        const double exact = reference_light(curve, 0, code / 255.0);
        EXPECT_NEAR(in_table(texels, code / 255.0, 0), exact, 1.0 / 65535) << "of full scale, code " << code;
        EXPECT_NEAR(255.0 * in_table(texels, std::sqrt(exact), 4), code, 0.05)
            << "steps of 255, " << entries << " entries";
      }
    }
}

TEST(ResponseTable, NeverDecreases) {
  const auto texels = response_texels(table_of([](double x) { return std::pow(x, 3.0); }, 100));
  for (const int row : {0, 1, 2, 4, 5, 6})
    for (int i = 1; i + 1 < kResponseEntries; ++i)
      EXPECT_GE(texels.at(i, row).r * 256 + texels.at(i, row).g,
                texels.at(i - 1, row).r * 256 + texels.at(i - 1, row).g);
}

TEST(Mipmaps, AverageInLinearLight) {
  Image<glm::u8vec4> board(4, 4);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x)
      board.at(x, y) = (x + y) % 2 == 0 ? glm::u8vec4{255, 255, 255, 255} : glm::u8vec4{0, 0, 0, 255};
  const auto half = halved(board);
  ASSERT_EQ(half.width(), 2);
  for (const glm::u8vec4 texel : half.elements()) EXPECT_EQ(texel, glm::u8vec4(188, 188, 188, 255));  // sRGB of 0.5
}

TEST(Mipmaps, PreserveTheMeanOfOddSizes) {
  Image<glm::u8vec4> line(5, 1, glm::u8vec4{0, 0, 0, 255});
  line.at(2, 0) = {255, 255, 255, 255};
  const auto half = halved(line);
  ASSERT_EQ(half.width(), 2);
  ASSERT_EQ(half.height(), 1);
  // Each new texel covers 2.5 old ones, half of the white one: 0.2 of light, sRGB 124.
  EXPECT_EQ(half.at(0, 0), glm::u8vec4(124, 124, 124, 255));
  EXPECT_EQ(half.at(1, 0), glm::u8vec4(124, 124, 124, 255));
}

TEST(Mipmaps, IgnoreTheColourOfTransparentTexels) {
  Image<glm::u8vec4> pair(2, 1, glm::u8vec4{0, 255, 0, 0});
  pair.at(0, 0) = {200, 10, 10, 255};
  EXPECT_EQ(halved(pair).at(0, 0), glm::u8vec4(200, 10, 10, 128));
}

}  // namespace
}  // namespace kasumi
