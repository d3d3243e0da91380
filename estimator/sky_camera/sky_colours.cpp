#include "estimator/sky_camera/sky_colours.hpp"

#include <cmath>
#include <map>

#include "estimator/sky/preetham.hpp"

namespace kasumi {
namespace {

constexpr double kCell = 6.0 * kPi / 180.0;  // [rad]: 6 deg, over which a clear sky's colour hardly changes
constexpr int kLeastElements = 12;           // fewer elements' mean is noise

struct Sum {
  DaylightWeights spectrum;
  glm::dvec2 log_ratio{};
  int elements = 0;
};

}  // namespace

std::vector<DaylightColour> sky_colours(const SkyPicture& picture, const TurbidityObservation& observation,
                                        const Camera& camera, Turbidity turbidity, int number) {
  const PreethamSky model(turbidity, observation.estimate.sun);
  std::map<std::pair<int, int>, Sum> cells;
  for (int y = 0; y < observation.use.height(); ++y)
    for (int x = 0; x < observation.use.width(); ++x) {
      if (observation.use.at(x, y) != PixelUse::clear) continue;
      const auto direction = camera.direction_at(picture.camera_pixel(x, y));
      if (!direction) continue;
      const auto light = camera.response.to_light(glm::dvec3(picture.encoded.at(x, y)));
      if (!(light.r > 0.0 && light.g > 0.0 && light.b > 0.0)) continue;
      const double zenith = zenith_angle(*direction).value;
      const int ring = static_cast<int>(zenith / kCell);
      const int sectors = std::max(1, static_cast<int>(2.0 * kPi * std::sin((ring + 0.5) * kCell) / kCell));
      const int sector = static_cast<int>(azimuth_angle(*direction).value / (2.0 * kPi) * sectors);
      const auto colour = model.luminance_and_chromaticity(*direction);
      const auto weights = daylight_weights(colour.y, colour.z);
      auto& sum = cells[{ring, sector}];
      sum.spectrum.m1 += weights.m1;
      sum.spectrum.m2 += weights.m2;
      sum.log_ratio += glm::dvec2{std::log(light.r / light.g), std::log(light.b / light.g)};
      ++sum.elements;
    }
  std::vector<DaylightColour> colours;
  for (const auto& [place, sum] : cells) {
    if (sum.elements < kLeastElements) continue;
    const double n = sum.elements;
    colours.push_back({{sum.spectrum.m1 / n, sum.spectrum.m2 / n}, sum.log_ratio / n, number});
  }
  return colours;
}

}  // namespace kasumi
