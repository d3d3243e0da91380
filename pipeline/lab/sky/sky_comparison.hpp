// Earlier sky models next to Kasumi's: the flaws that U Chapter 5.4.1 describes, as pictures and numbers.
#pragma once

#include <string>
#include <vector>

#include "estimator/sky/sky_scene.hpp"

namespace kasumi {

struct FormulaFlaws {
  SkyKind kind = SkyKind::dome;
  // The dark band: the darkest luminance along a circle around the zenith over that opposite the sun; 1: none.
  double band = 1.0;
  // Chromaticity of the zenith. Blue is nearer to (0.24, 0.24) than daylight's white (0.3127, 0.329).
  double zenith_x = 0.0, zenith_y = 0.0;
  double zenith_luminance = 0.0;  // cd/m2
};
// band: along the sun's own circle around the zenith, where it stands at `sun`; the zenith: under the sun of `low_sun`.
FormulaFlaws flaws_of(SkyKind kind, Turbidity turbidity, const SunDirection& sun, const SunDirection& low_sun);

}  // namespace kasumi
