// Skies to be told apart: closed covers, broken clouds and cloudless ones, as unlike the estimator's models as could be
// thought of. Two populations that share no texture, no aerosol and no parameter: one to choose limits by, one to hold
// them to.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "base/geometry.hpp"

namespace kasumi::test {

enum class Cover { overcast, broken, cloudless };
enum class Population { development, held_out };
constexpr double kPopulationAltitude_m = 300.0;

struct PopulationSky {
  Cover cover = Cover::cloudless;
  std::string kind;               // "stratus, sun veiled"
  double cloud_share = 0.0;       // of the sky above 12 deg
  std::optional<double> aod_550;  // of the air, where there is an answer
  Direction sun{0.0, 0.0, 1.0};
  std::function<glm::dvec3(const Direction&)> light;  // linear sRGB, any unit; without the sun's disc
  glm::dvec3 beam{0.0};                               // irradiance of the sun's disc as it is seen, same unit
};

// `folder`: of measured skies; they join the held out cloudless ones where it exists.
std::vector<PopulationSky> overcast_skies(Population population, int count);
std::vector<PopulationSky> cloudless_skies(Population population, int count, const std::string& folder);
// Broken clouds of every cover before cloudless skies.
std::vector<PopulationSky> broken_skies(Population population, int count, const std::vector<PopulationSky>& cloudless);

}  // namespace kasumi::test
