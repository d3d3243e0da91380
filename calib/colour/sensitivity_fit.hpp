// The spectral sensitivity of a camera from the colours of clear skies, after Kawakami et al. 2013.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "base/result.hpp"
#include "calib/colour/colorimetry.hpp"
#include "calib/colour/spectral_sensitivity.hpp"

namespace kasumi {

// One part of a clear sky: its spectrum, and the colour the camera measures.
struct DaylightColour {
  DaylightWeights spectrum;  // S0 + m1 S1 + m2 S2, however bright
  glm::dvec2 log_ratio{};    // ln(red / green), ln(blue / green) of the camera's linear light; gains not removed
  int picture = 0;           // which of the pictures it was seen in
};

// The gains that explain the colours best under a given sensitivity.
struct ColourResiduals {
  glm::dvec3 white_balance{1.0};  // gains; green's is 1
  double rms = 0.0;               // residual of the log ratios, over the parts that agree
  std::vector<glm::dvec2> left;   // log ratio, measured less modelled; one per colour
  std::vector<bool> used;         // of those that agree; one per colour
};
ColourResiduals explain(std::span<const DaylightColour> colours, const SpectralSensitivity& sensitivity);

// One channel's mean wavelength.
struct ChannelPlace {
  double mean_nm = 0.0;          // of the sensitivity
  double sigma_nm = 0.0;         // with the sky
  double before_sigma_nm = 0.0;  // from the measured cameras alone
};

struct SensitivityFit {
  SpectralSensitivity sensitivity;  // 380-780 nm in 5 nm; channels of one area, so that gains are against an even light
  ColourResiduals residuals;
  glm::dvec2 gain_sigma{};  // relative, of red's and blue's gain
  std::array<ChannelPlace, 3> places;
  int determined = 0;      // how many of the 6 numbers that daylight determines of three channels are known better
                           // from the sky than from the measured cameras
  double condition = 0.0;  // of the 6 numbers: ratio of the standard deviations of the worst and the best determined
};

// Daylight spectra span three dimensions, so the sky determines two numbers of each channel q: the integrals of q S1
// and q S2 over that of q S0. The rest comes from a Gaussian prior: the measured cameras' mean, with deviations like
// theirs and smooth ones. The result is the most probable non-negative sensitivity. Outlying colours are weighted down
// (Tukey). Errors of neighbouring parts of a sky are correlated, so a picture counts as kIndependentParts however many
// colours it has.
// Errors (bad_input): fewer than 2 cameras, a camera that cannot distinguish daylights, fewer than 8 colours.
constexpr double kIndependentParts = 25.0;
Result<SensitivityFit> fit_sensitivity(std::span<const DaylightColour> colours,
                                       std::span<const SpectralSensitivity> cameras);

// The colours that a camera of this sensitivity would measure of the same skies, plus the sky's residuals `left`.
std::vector<DaylightColour> seen_by(const SpectralSensitivity& sensitivity, std::span<const DaylightColour> colours,
                                    std::span<const glm::dvec2> left);

// A CSV that read_spectral_sensitivity reads again; `comment` becomes its first lines.
std::string csv_of(const SpectralSensitivity& sensitivity, const std::string& comment);

}  // namespace kasumi
