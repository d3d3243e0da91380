// What the air at a given turbidity does to light, as coefficients for a path's transparency. The path itself is in
// base/sky/air_path.glsl (C++: sky_text::path_transparency(text_of(air), ...) of base/sky/dome_scene.hpp).
#pragma once

#include "base/sky/dome_function.hpp"
#include "estimator/atmosphere.hpp"

namespace kasumi {

// For light in linear sRGB. Molecules after Bodhaine 1999; aerosol by the same mapping of T as the dome's
// (docs/sky.md): Angstrom's optical depth (.04608 T - .04586) um^-1.3 over a scale height of 1200 m; ozone of the
// dome's atmosphere.
AirCoefficients air_coefficients(Turbidity turbidity);

}  // namespace kasumi
