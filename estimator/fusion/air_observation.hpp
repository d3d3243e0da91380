// What an observer says of the air at one moment.
#pragma once

#include <array>
#include <string_view>

#include "estimator/atmosphere.hpp"

namespace kasumi {

// supposed: no observation yet; the usual air is assumed.
enum class AirObserver { sky, landmarks, horizon, remembered, given, supposed };
std::string_view name_of(AirObserver observer);

// The aerosol of the column: from a sky camera, or from the low sky in the scene camera (horizon).
struct ColumnReading {
  AirObserver by = AirObserver::sky;
  FoundAerosol found;
};

// Extinction of the air near the ground, by molecules and aerosol, in the scene camera's channels.
struct PathReading {
  AirObserver by = AirObserver::landmarks;
  struct Channel {
    enum class Kind { nothing, value, at_most, at_least } kind = Kind::nothing;
    double wavelength_nm = 550.0;  // effective, of the channel
    double per_m = 0.0, sigma_per_m = 0.0;
  };
  std::array<Channel, 3> channels{};
  double shared_sigma = 0.0;  // relative, common to the three: distances, contrasts that light and weather change alike
};

}  // namespace kasumi
