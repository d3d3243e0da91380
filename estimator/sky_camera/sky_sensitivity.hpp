// The sky camera's spectral sensitivity and white balance, from a recording of clear skies.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "calib/colour/sensitivity_fit.hpp"
#include "estimator/sky_camera/sensitivity_error.hpp"
#include "estimator/sky_camera/sun_moment.hpp"

namespace kasumi {

struct SensitivityRequest {
  std::optional<double> turbidity{};  // known T of all the pictures; empty: each picture's own estimate
  bool choose = false;                // take the best of the measured cameras instead of a fit
};

// How well a measured camera explains the sky's colours.
struct RankedSensitivity {
  std::size_t camera = 0;  // index into the given cameras
  ColourResiduals residuals;
};

struct FoundSensitivity {
  SpectralSensitivity sensitivity;        // the result: the fit, or the best of the measured cameras
  ColourResiduals residuals;              // of that result
  std::vector<RankedSensitivity> ranked;  // best first
  std::optional<SensitivityFit> fit;
  std::size_t colours = 0;           // number of sky cells used
  std::vector<double> turbidities;   // of the pictures used
  std::vector<std::string> refused;  // the pictures not used, as "NAME: why"
  std::vector<GammaError> expected;  // leave_one_out under these skies
  // The largest error of Gamma if the real sky were more colourful than the model's by kMoreColourful. No residual
  // shows this, since another sensitivity absorbs it. Only for a fit.
  std::optional<double> of_more_colourful_sky;
};
// Chosen: what Preetham's chromaticities may lack of a real sky's distance from white.
constexpr double kMoreColourful = 0.1;

// T is estimated from the camera's luminance, which depends on the sensitivity: a few rounds settle both. `camera`
// supplies lens, orientation, response and vignetting; its colour description is ignored. `cameras`: the measured ones,
// at least one; a fit needs two. Errors (bad_input): no picture shows a clear enough sky, at first or with the
// sensitivity found; those of fit_sensitivity.
Result<FoundSensitivity> sensitivity_from_sky(Camera camera, std::span<const SunMoment> moments,
                                              std::span<const SpectralSensitivity> cameras,
                                              const SensitivityRequest& options = {});

}  // namespace kasumi
