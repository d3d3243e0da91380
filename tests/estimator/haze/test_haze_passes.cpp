// The passes, which work in place and several at a time, against a pixel by pixel implementation of their definition.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/estimator/haze/haze_scenes.hpp"

namespace kasumi {
namespace {

int mirrored(int at, int size) {
  return at < 0 ? -1 - at : at < size ? at : 2 * size - 1 - at;
}

double joined(const Image<float>& steps, int x, int y, int ox, int oy) {
  const double apart = std::abs(static_cast<double>(steps.at(x, y)) - static_cast<double>(steps.at(ox, oy)));
  const double t = std::clamp((0.04 - apart) / (0.04 - 0.02), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

// F(x) += sum g(x, x+u) (F(x+u) - F(x)), all pixels at once.
template <class Conductance>
Image<glm::dvec4> one_pass(const Image<glm::dvec4>& light, int d, Conductance g) {
  auto after = light;
  for (int y = 0; y < light.height(); ++y)
    for (int x = 0; x < light.width(); ++x) {
      const int left = mirrored(x - d, light.width()), right = mirrored(x + d, light.width());
      const int above = mirrored(y - d, light.height()), below = mirrored(y + d, light.height());
      for (const int ox : {left, right}) after.at(x, y) += g(x, y, ox, y) * (light.at(ox, y) - light.at(x, y));
      for (const int oy : {above, below}) after.at(x, y) += g(x, y, x, oy) * (light.at(x, oy) - light.at(x, y));
    }
  return after;
}

double wanted(const BlurMap& map, int x, int y) {
  const auto sigma = static_cast<double>(map.sigma_px.at(x, y));
  return sigma * sigma - map.inner_px * map.inner_px;
}

// Widths that vary from pixel to pixel, and two surfaces.
BlurMap hills(int width, int height, double widest_px) {
  BlurMap map;
  map.sigma_px = map.steps_along_row = map.steps_down_column = Image<float>(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double part = 0.5 + 0.5 * std::sin(0.011 * x + 0.3 * y) * std::cos(0.07 * x);
      map.sigma_px.at(x, y) = static_cast<float>(1.0 + (widest_px - 1.0) * part);
      const bool front = x > width / 4 && x < width / 2 && y > height / 3;
      map.steps_along_row.at(x, y) = map.steps_down_column.at(x, y) =
          front ? 0.3F : 0.002F * static_cast<float>(x % 17);
    }
  map.sigma_px.at(width / 3, height / 2) = static_cast<float>(widest_px);
  return map;
}

Image<glm::dvec4> in_double(const Image<glm::vec4>& picture) {
  Image<glm::dvec4> copy(picture.width(), picture.height());
  std::ranges::transform(picture.elements(), copy.elements().begin(), [](const glm::vec4& p) { return glm::dvec4(p); });
  return copy;
}

double worst_of(const Image<glm::vec4>& one, const Image<glm::dvec4>& other) {
  double worst = 0.0;
  for (std::size_t i = 0; i < one.elements().size(); ++i)
    for (int c = 0; c < 4; ++c)
      worst = std::max(worst, std::abs(static_cast<double>(one.elements()[i][c]) - other.elements()[i][c]));
  return worst;
}

// Wide enough that not all passes fit in the cache at once; no higher than the farthest offset.
constexpr int kWidth = 1400, kHeight = 19;

TEST(HazePasses, MatchedPassesAreTheirDefinition) {
  auto map = hills(kWidth, kHeight, 25.0);
  const auto picture = bars(kWidth, kHeight);
  const auto passes = matched_passes(1.0, 25.0);
  ASSERT_EQ(passes.back().offset_px, kHeight);
  for (const bool surfaces : {true, false}) {
    if (!surfaces) map.steps_along_row = map.steps_down_column = {};
    auto truth = in_double(picture);
    for (const auto& pass : passes)
      truth = one_pass(truth, pass.offset_px, [&](int x, int y, int ox, int oy) {
        const double rate = std::min(pass.rate(wanted(map, x, y)), pass.rate(wanted(map, ox, oy)));
        if (!surfaces) return rate;
        return rate * joined(y == oy ? map.steps_along_row : map.steps_down_column, x, y, ox, oy);
      });
    const auto blurred = diffuse(DiffusionScheme::matched, picture, map).value();
    EXPECT_LT(worst_of(blurred, truth), 1e-6) << "of light up to 1";
  }
}

TEST(HazePasses, ExplicitPassesAreTheirDefinition) {
  const auto map = hills(kWidth, kHeight, 8.0);
  const auto picture = bars(kWidth, kHeight);
  const int count = passes_of(DiffusionScheme::explicit_steps, 1.0, 8.0);
  ASSERT_EQ(count, 126);
  auto truth = in_double(picture);
  for (int k = 0; k < count; ++k)
    truth = one_pass(truth, 1, [&](int x, int y, int ox, int oy) {
      return 0.5 * (wanted(map, x, y) + wanted(map, ox, oy)) * 0.5 / count;
    });
  const auto blurred = diffuse(DiffusionScheme::explicit_steps, picture, map).value();
  EXPECT_LT(worst_of(blurred, truth), 3e-6) << "of light up to 1";
}

}  // namespace
}  // namespace kasumi
