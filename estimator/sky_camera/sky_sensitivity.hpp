// The sky camera's spectral sensitivity and white balance, from a recording of clear skies.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "calib/colour/sensitivity_fit.hpp"
#include "estimator/sky_camera/sensitivity_error.hpp"
#include "estimator/sky_camera/sky_moment.hpp"

namespace kasumi {

struct SkySensitivityOptions {
  std::optional<double> turbidity{};  // T of all the pictures from elsewhere; empty: each picture's own estimate
  bool choose = false;                // the measured camera that explains the sky best, instead of a fit
};

// How well a measured camera explains the colours.
struct RankedCamera {
  std::size_t camera = 0;  // its place among those that were given
  ColourResiduals residuals;
};

struct SkySensitivity {
  SpectralSensitivity sensitivity;   // what is taken: the fit, or the best of the measured cameras
  ColourResiduals residuals;         // with it
  std::vector<RankedCamera> ranked;  // best first
  std::optional<SensitivityFit> fit;
  std::size_t colours = 0;           // parts of sky that were looked at
  std::vector<double> turbidities;   // of the pictures that were used
  std::vector<std::string> refused;  // "NAME: why", of the others
  std::vector<GammaError> expected;  // leave_one_out under these skies
  // The largest error of Gamma if the real sky were kMoreColourful more colourful than the model's, which no residual
  // shows: another sensitivity takes it up. Of a fit only.
  std::optional<double> of_more_colourful_sky;
};
constexpr double kMoreColourful = 0.1;

// T is found through the camera's own idea of luminance, and that through the sensitivity: a few rounds settle both.
// `camera` with its lens, orientation, response and vignetting; what it says of colour is not looked at. `cameras`: the
// measured ones, at least one; a fit needs two. Errors (bad_input): no picture shows a sky that is clear enough, at
// first or by the sensitivity found; those of fit_sensitivity.
Result<SkySensitivity> sensitivity_from_sky(Camera camera, std::span<const SkyMoment> moments,
                                            std::span<const SpectralSensitivity> cameras,
                                            const SkySensitivityOptions& options = {});

}  // namespace kasumi
