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

// A model of one texture, and a material of each of these kinds that shows it.
Model wearing(const Image<glm::u8vec4>& picture, const std::vector<ModelMaterial::Alpha>& kinds) {
  Model model;
  model.textures.push_back({picture});
  for (const auto kind : kinds) {
    model.materials.emplace_back().texture = 0;
    model.materials.back().alpha = kind;
  }
  return model;
}

TEST(Mipmaps, TransparentTexelsHaveTheColourOfWhatIsVisibleAround) {
  constexpr glm::u8vec4 kLeaf{40, 120, 30, 255};
  Image<glm::u8vec4> leaves(12, 10, glm::u8vec4{0, 0, 0, 0});
  leaves.at(2, 3) = kLeaf;
  leaves.at(9, 7) = {40, 120, 30, 90};
  for (const auto kind : {ModelMaterial::Alpha::mask, ModelMaterial::Alpha::blend}) {
    Model model = wearing(leaves, {kind});
    make_levels(model);
    const ModelTexture& texture = model.textures[0];
    std::vector<Image<glm::u8vec4>> levels = texture.smaller;
    levels.push_back(texture.pixels);
    for (const auto& level : levels)
      for (const glm::u8vec4 texel : level.elements()) ASSERT_EQ(glm::u8vec3(texel), glm::u8vec3(kLeaf));
    for (std::size_t i = 0; i < leaves.elements().size(); ++i)
      ASSERT_EQ(texture.pixels.elements()[i].a, leaves.elements()[i].a);
  }
}

TEST(Mipmaps, AlphaThatNoMaterialShowsWeighsNoColour) {
  Image<glm::u8vec4> board(2, 1, glm::u8vec4{255, 255, 255, 0});
  board.at(1, 0) = {0, 0, 0, 255};
  Model opaque = wearing(board, {ModelMaterial::Alpha::opaque});
  make_levels(opaque);
  EXPECT_EQ(opaque.textures[0].smaller.at(0).at(0, 0), glm::u8vec4(188, 188, 188, 255));
  Model both = wearing(board, {ModelMaterial::Alpha::opaque, ModelMaterial::Alpha::mask});
  make_levels(both);
  EXPECT_EQ(both.textures[0].pixels.at(0, 0), board.at(0, 0)) << "the opaque one shows this colour";
}

// A fence of wires, 1 texel in `apart` each way, that is cut out.
TEST(Mipmaps, WiresThatCoverLittleKeepTheirShareInTheDistance) {
  for (const int apart : {8, 16, 32, 64}) {
    Image<glm::u8vec4> fence(256, 256, glm::u8vec4{90, 90, 90, 0});
    for (int y = 0; y < 256; ++y)
      for (int x = 0; x < 256; ++x)
        if (x % apart == 0 || y % apart == 0) fence.at(x, y).a = 255;
    const double share = share_above(fence, 0.5);
    for (const auto& level : smaller_levels(fence, false, 0.5)) {
      const double texel = 1.0 / static_cast<double>(level.elements().size());
      EXPECT_NEAR(share_above(level, 0.5), share, 0.1 * share + 0.6 * texel) << apart << " at " << level.width();
    }
  }
}

}  // namespace
}  // namespace kasumi
