// The sun's disc as the Earth sees it: .2666 deg of radius at the mean distance (959.63"), 1.7 % more or less over the
// year. Each result keeps the digits it was made with; they differ by less than the year makes.
#pragma once

#include "base/units.hpp"

namespace kasumi {

constexpr Radians kSunRadius = from_degrees(0.2665);  // penumbras
constexpr double kSettingSunRadius_deg = 0.2666;      // how much of it stands above the horizon
constexpr float kDomeSunRadius_rad = 0.004651F;       // what the dome's sun (base/sky/dome_function.hpp) is drawn with
constexpr double kSunDisc_sr = 6.797e-5;              // of kSunRadius

}  // namespace kasumi
