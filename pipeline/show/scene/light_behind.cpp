#include "pipeline/show/scene/light_behind.hpp"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/exponential.hpp>

#include "pipeline/show/scene/for_gles.hpp"

namespace kasumi {
namespace {

constexpr std::uint8_t kNothingBefore = 250;  // of the mask
constexpr int kSamples = 12;                  // along a side of a point's surroundings
constexpr double kDoubt = 0.6;                // of the optical depth: landmarks and sky are right within some 30 %

}  // namespace

std::optional<AirlightGrid> light_behind(const Camera& scene, const PictureView& picture, const PixelBox& box,
                                         const HorizonLight& horizon) {
  if (box.empty() || !horizon.usable() || picture.width != scene.width || picture.height != scene.height)
    return std::nullopt;
  const glm::dvec2 half = 0.5 * glm::dvec2(box.right - box.left, box.bottom - box.top) /
                          glm::dvec2(AirlightGrid::kColumns - 1, AirlightGrid::kRows - 1);
  const glm::ivec2 last{scene.width - 1, scene.height - 1};
  return airlight_grid(scene, box, [&](const glm::dvec2& pixel, const Direction& direction) {
    glm::dvec3 sum{0.0};
    int count = 0;
    for (int row = 0; row < kSamples; ++row)
      for (int column = 0; column < kSamples; ++column) {
        const glm::dvec2 share = (2.0 * glm::dvec2(column, row) + 1.0) / static_cast<double>(kSamples) - 1.0;
        const glm::ivec2 at = glm::clamp(glm::ivec2(glm::round(pixel + share * half)), glm::ivec2(0), last);
        if (!scene.mask.empty() && scene.mask.at(at.x, at.y) < kNothingBefore) continue;
        sum += scene.light_at(glm::dvec2(at), glm::dvec3(rgb_at(picture, at.x, at.y)) / 255.0);
        ++count;
      }
    if (count == 0) return glm::dvec3{kNoBound};
    const glm::dvec3 beyond = glm::max(column_at(horizon, azimuth_angle(direction)).light, 1e-6);
    return glm::min(sum / static_cast<double>(count) / beyond, kNoBound);
  });
}

glm::dvec3 most_airlight(const glm::dvec3& seen, const glm::dvec3& left) {
  return seen / glm::max(1.0 - glm::pow(glm::clamp(left, 0.0, 1.0), glm::dvec3{kDoubt}), 1e-3);
}

}  // namespace kasumi
