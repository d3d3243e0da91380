// The sun's disc as seen from the Earth: a radius of .2666 deg at the mean distance (959.63"), +-1.7 % over the year.
// Each use keeps its own digits, so that results stay reproducible; they differ by less than the annual variation.
#pragma once

#include "base/units.hpp"

namespace kasumi {

constexpr Radians kSunRadius = from_degrees(0.2665);  // penumbras
constexpr double kSettingSunRadius_deg = 0.2666;      // the share of the disc above the horizon
constexpr float kDomeSunRadius_rad = 0.004651F;       // what the dome's sun (base/sky/dome_function.hpp) is drawn with
constexpr double kSunDisc_sr = 6.797e-5;              // of kSunRadius

}  // namespace kasumi
