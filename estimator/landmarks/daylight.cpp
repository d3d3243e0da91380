#include "estimator/landmarks/daylight.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

namespace kasumi {
namespace {

// Chosen: JPEG may leave as much colour in grey, and as little of white; De Bilt's infrared frames then have under .5 %
// of coloured pixels (physics 11).
constexpr float kColourless = 3.0F / 255.0F, kFullScale = 252.0F / 255.0F;
// Two of JPEG's blocks: enough pixels for a median of the noise, few enough to lie on one surface.
constexpr int kBlock_px = 16;

// By day a camera's noise is 1 or 2 of 255 where it is bright, by night, with all its gain, 4 to 9.
constexpr double kNightNoise = 3.0 / 255.0;
constexpr double kFewestColoured = 0.03;  // a date written into the picture leaves some pixels of colour
// Grey fog by day is without contrast (docs/physics.md 11, "By day only")
constexpr double kFogRange = 50.0 / 255.0;
constexpr double kNightSky = 50.0 / 255.0;  // chosen: exposure control keeps a sky by day brighter
// Chosen: lamps are a few full-scale points on land under a dark sky; more than 5 % is sunlit snow or a burnt picture.
constexpr double kLampSky = 110.0 / 255.0, kFewestLamps = 2e-4, kMostLamps = 0.05;

double quantile_of(std::vector<float>& values, double share) {
  if (values.empty()) return 0.0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// Of a block: the median second difference along rows, which edges and gradients hardly touch, as a standard deviation.
// Where most pixels are at an end of the scale there is no noise to see: empty.
std::optional<float> noise_in(const Image<glm::vec3>& encoded, int left, int top) {
  std::vector<float> differences;
  int at_an_end = 0;
  for (int y = top; y < top + kBlock_px; ++y)
    for (int x = left + 1; x + 1 < left + kBlock_px; ++x) {
      const float green = encoded.at(x, y).g;
      if (green <= 0.0F || green >= kFullScale) ++at_an_end;
      differences.push_back(std::abs(2.0F * green - encoded.at(x - 1, y).g - encoded.at(x + 1, y).g));
    }
  if (2 * at_an_end > static_cast<int>(differences.size())) return std::nullopt;
  return static_cast<float>(quantile_of(differences, 0.5) / (0.6745 * std::sqrt(6.0)));
}

}  // namespace

DaylightLook look_for_daylight(const Image<glm::vec3>& encoded) {
  DaylightLook look;
  const int width = encoded.width(), height = encoded.height();
  if (width < kBlock_px || height < kBlock_px) return look;
  std::vector<float> upper, lower, all, noises;
  std::size_t coloured = 0, full = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto& pixel = encoded.at(x, y);
      const auto [least, most] = std::minmax({pixel.r, pixel.g, pixel.b});
      if (most - least > kColourless + 1e-6F) ++coloured;
      (2 * y < height ? upper : lower).push_back(pixel.g);
      if (2 * y >= height && most >= kFullScale) ++full;
      all.push_back(pixel.g);
    }
  for (int y = 0; y + kBlock_px <= height; y += kBlock_px)
    for (int x = 0; x + kBlock_px <= width; x += kBlock_px)
      if (const auto noise = noise_in(encoded, x, y)) noises.push_back(*noise);
  look.coloured = static_cast<double>(coloured) / static_cast<double>(all.size());
  look.noise = quantile_of(noises, 0.25);
  look.sky = quantile_of(upper, 0.5);
  look.brightest_sky = quantile_of(upper, 0.95);
  look.range = quantile_of(all, 0.95) - quantile_of(all, 0.05);
  look.land = quantile_of(lower, 0.5);
  look.lamps = static_cast<double>(full) / static_cast<double>(lower.size());
  return look;
}

std::string why_not_daylight(const DaylightLook& look, const std::optional<Direction>& sun) {
  if (sun && sun->z < 0.0) return "by night: the sun is below the horizon";
  if (look.coloured < kFewestColoured && (look.noise > kNightNoise || look.range > kFogRange))
    return "infrared or black and white: the picture has no colours, and in infrared light leaves are as bright as "
           "haze";
  if (look.brightest_sky < kNightSky) return "by night: the sky is dark";
  if (look.noise > kNightNoise)
    return fmt::format("by night: the camera's noise is {:.0f} of 255, as with all its gain", 255.0 * look.noise);
  if (look.sky < kLampSky && look.land < look.sky && look.lamps > kFewestLamps && look.lamps < kMostLamps)
    return "by night: lamps on dark land under a dark sky";
  return {};
}

}  // namespace kasumi
