#include "pipeline/show/stage/text_plate.hpp"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>

namespace kasumi {
namespace {

// A warm white on a cold black, as in print; the background keeps text readable before a bright sky.
constexpr glm::dvec3 kTextColour{247, 246, 241};
constexpr glm::dvec3 kBackground{17, 19, 23};

// Coverage of a pixel by the rounded rectangle that fills the picture, from its centre's distance to the edge.
double inside_rounded(int x, int y, int width, int height, double radius) {
  const double dx = std::max(std::abs(x + 0.5 - width / 2.0) - (width / 2.0 - radius), 0.0);
  const double dy = std::max(std::abs(y + 0.5 - height / 2.0) - (height / 2.0 - radius), 0.0);
  if (dx == 0.0 || dy == 0.0) return 1.0;
  return std::clamp(radius - std::hypot(dx, dy) + 0.5, 0.0, 1.0);
}

Rgba8 text_over_background(double text, double background) {
  const double opacity = text + background * (1.0 - text);
  if (opacity <= 0.0) return {};
  const glm::dvec3 colour = (kTextColour * text + kBackground * background * (1.0 - text)) / opacity;
  return {glm::round(glm::dvec4(colour, 255.0 * opacity))};
}

}  // namespace

Image<Rgba8> text_plate(const Image<std::uint8_t>& coverage, double background_opacity, double radius_px) {
  const int width = coverage.width(), height = coverage.height();
  const double radius = std::min({radius_px, 0.5 * width, 0.5 * height});
  Image<Rgba8> picture(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      picture.at(x, y) = text_over_background(coverage.at(x, y) / 255.0,
                                              background_opacity * inside_rounded(x, y, width, height, radius));
  return picture;
}

}  // namespace kasumi
