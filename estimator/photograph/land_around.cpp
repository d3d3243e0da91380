#include "estimator/photograph/land_around.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "calib/mask/guided_filter.hpp"
#include "estimator/photograph/path_transmittance.hpp"

namespace kasumi {
namespace {

constexpr double kFlat = 0.01;       // variance of the guide
constexpr float kDistances = 3.0F;   // of ln distance
constexpr float kBrightness = 0.5F;  // of encoded brightness: sun next to shade is no edge yet, white next to black is
constexpr int kLargeEnough = 500;    // pixels of the longer side at which surroundings are resolved well enough
constexpr float kHidden = 1e-4F;     // a weight too small to influence anything
const glm::vec3 kGuideWeights{0.3F, 0.6F, 0.1F};

}  // namespace

Image<glm::vec3> land_around(const Image<glm::vec3>& light, const RetargetGeometry& depth, const RetargetAir& air,
                             const AttenuationNodes& nodes, const LandAroundParameters& options) {
  const int width = light.width(), height = light.height(), longer = std::max(width, height);
  const PathTransmittance paths(nodes, options.scattering, air.state);
  float farthest_m = 1.0F;
  for (const float distance_m : depth.distance_m.elements()) farthest_m = std::max(farthest_m, distance_m);
  Image<glm::vec3> guide(width, height), own(width, height, glm::vec3{1.0F});
  Image<float> weight(width, height);
  std::array<Image<float>, 3> weighed{weight, weight, weight};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto relative = light.at(x, y) / glm::max(air.of(x, y), glm::vec3{1e-9F});
      const float distance_m = depth.distance_m.at(x, y);
      const bool land = distance_m > 0.0F;
      guide.at(x, y) = {kBrightness * std::sqrt(glm::dot(kGuideWeights, glm::min(relative, 4.0F))),
                        kDistances * std::log(land ? distance_m : 1.5F * farthest_m), 0.0F};
      if (!land) continue;
      const auto left = glm::max(glm::vec3(paths.transmittance(depth.path(x, y)).value()), glm::vec3{1e-9F});
      own.at(x, y) = 1.0F + (relative - 1.0F) / left;
      weight.at(x, y) = left.g * left.g;  // noise of `own` grows as 1 / left
      for (int c = 0; c < 3; ++c)
        weighed[static_cast<std::size_t>(c)].at(x, y) = weight.at(x, y) * (own.at(x, y)[c] - 1.0F);
    }
  const int radius_px = std::max(2, static_cast<int>(std::lround(options.window * longer)));
  const int step = std::clamp(longer / kLargeEnough, 1, std::max(1, radius_px / 2));
  const auto around = [&](const Image<float>& values) { return guided_filter(guide, values, radius_px, kFlat, step); };
  const auto weights = around(weight);
  for (int c = 0; c < 3; ++c) {
    const auto sums = around(weighed[static_cast<std::size_t>(c)]);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        if (!(depth.distance_m.at(x, y) > 0.0F)) continue;
        // Next to something much clearer the filter may not reach any pixels like this one: then it has no
        // surroundings.
        if (weights.at(x, y) > 0.2F * weight.at(x, y))
          own.at(x, y)[c] = 1.0F + sums.at(x, y) / std::max(weights.at(x, y), kHidden);
        own.at(x, y)[c] = std::max(own.at(x, y)[c], 0.0F);
      }
  }
  return own;
}

}  // namespace kasumi
