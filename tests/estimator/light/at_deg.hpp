// Directions in degrees.
#pragma once

#include "base/geometry.hpp"

namespace kasumi {

inline Direction at_deg(double zenith, double azimuth) {
  return direction_from(from_degrees(zenith), from_degrees(azimuth));
}

}  // namespace kasumi
