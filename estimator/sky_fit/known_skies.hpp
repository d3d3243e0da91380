// Clear skies over the whole range of what air can be, as ln light in the directions of some readings: for questions
// that need no exact answer, but must not depend on which sky it is.
#pragma once

#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "estimator/atmosphere.hpp"
#include "estimator/sky_fit/sky_reading.hpp"

namespace kasumi {

struct KnownRadiance {
  double aod_550 = 0.0;
  std::vector<glm::dvec3> log_light;  // of each reading: linear sRGB, any unit
};

// Preetham's of T 2 to 8, and the dome's of four kinds and two blends and an optical depth of 0 to 1.3.
std::vector<KnownRadiance> known_skies(std::span<const SkyReading> readings, const SunDirection& sun,
                                       double altitude_m);

// At most `count` of the readings, evenly.
std::vector<SkyReading> thinned(std::span<const SkyReading> readings, std::size_t count);

}  // namespace kasumi
