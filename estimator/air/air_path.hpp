// What air with a given aerosol does to light, as coefficients for a path's transparency. The path itself is in
// base/sky/air_path.glsl (C++: sky_text::path_transparency(text_of(air), ...) of base/sky/dome_scene.hpp).
#pragma once

#include "base/aerosol.hpp"
#include "base/sky/dome_function.hpp"
#include "estimator/atmosphere.hpp"

namespace kasumi {

// For light in linear sRGB. Molecules after Bodhaine 1999; aerosol by Angstrom's law, thinning out as e^(-h / 1200 m);
// ozone of the dome's atmosphere.
AirCoefficients air_coefficients(const Aerosol& aerosol);
inline AirCoefficients air_coefficients(Turbidity turbidity) {
  return air_coefficients(aerosol_of(turbidity.value));
}

}  // namespace kasumi
