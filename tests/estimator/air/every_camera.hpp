// The spectral sensitivities that figures are printed for.
#pragma once

#include <vector>

#include "calib/colour/spectral_sensitivity.hpp"

namespace kasumi {

// The generic one and, where the shared data is at hand, all cameras of it, by name.
std::vector<SpectralSensitivity> every_camera();

}  // namespace kasumi
