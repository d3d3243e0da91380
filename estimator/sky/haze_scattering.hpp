// How a kind of aerosol scatters, for the air before land: its albedo in red, green and blue, and two lobes in place of
// its phase function (docs/sky.md).
#pragma once

#include "base/aerosol.hpp"
#include "base/sky/sky_text.hpp"

namespace kasumi {

sky_text::HazeScattering haze_scattering(AerosolKind kind);
// Of a blend of two kinds the means by their shares.
sky_text::HazeScattering haze_scattering(const Aerosol& aerosol);

}  // namespace kasumi
