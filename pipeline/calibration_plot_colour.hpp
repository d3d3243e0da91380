// What `kasumi calibrate colour` did, as a picture.
#pragma once

#include <span>
#include <string>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "calib/sensitivity_fit.hpp"

namespace kasumi {

// Left: the sensitivity that was taken, each channel's largest 1, over those of the measured cameras (faint).
// Right: what is left of the log ratios of every part of the sky, green where used, red where left aside.
Image<Rgb8> plot_colour(const SpectralSensitivity& taken, std::span<const SpectralSensitivity> cameras,
                        const ColourResiduals& residuals, const std::string& title);

}  // namespace kasumi
