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

// One part of a clear sky: what spectrum it has, and what the camera makes of it.
struct SkyColour {
  DaylightWeights spectrum;  // S0 + m1 S1 + m2 S2, however bright
  glm::dvec2 log_ratio{};    // ln(red / green), ln(blue / green) of the camera's linear light; gains not removed
  int picture = 0;           // which of the pictures it was seen in
};

// What gains explain the colours best when the sensitivity is this one.
struct ColourResiduals {
  glm::dvec3 white_balance{1.0};  // gains; green's is 1
  double rms = 0.0;               // of what is left of the log ratios, over the parts that agree
  std::vector<glm::dvec2> left;   // log ratio, measured less modelled; one per colour
  std::vector<bool> used;         // of those that agree; one per colour
};
ColourResiduals explain(std::span<const SkyColour> colours, const SpectralSensitivity& sensitivity);

// What is known of one channel's place in the spectrum.
struct ChannelPlace {
  double mean_nm = 0.0;          // of the sensitivity
  double sigma_nm = 0.0;         // after the sky was seen
  double before_sigma_nm = 0.0;  // by the measured cameras alone
};

struct SensitivityFit {
  SpectralSensitivity sensitivity;  // 380-780 nm in 5 nm; channels of one area, so that gains are against an even light
  ColourResiduals residuals;
  glm::dvec2 gain_sigma{};  // relative, of red's and blue's gain
  std::array<ChannelPlace, 3> places;
  int determined = 0;      // how many of the 6 numbers that daylight can tell of three channels the sky tells better
                           // than the measured cameras do
  double condition = 0.0;  // best to worst told of the 6, as a ratio of standard deviations
};

// Daylight spectra span three dimensions, so that of each channel the sky tells two numbers: integrals of q S1 and q S2
// over that of q S0. The rest comes from the measured cameras: each channel is their mean, plus their deviations from
// it, plus smooth ones, as likely as theirs (a Gaussian prior), nowhere negative; of all such the most probable is
// taken. Colours that disagree are weighted down (Tukey). Errors of neighbouring parts of a sky are alike, so a picture
// counts as kIndependentParts however many colours it has.
// Errors (bad_input): fewer than 2 cameras, a camera that does not tell daylights apart, fewer than 8 colours.
constexpr double kIndependentParts = 25.0;
Result<SensitivityFit> fit_sensitivity(std::span<const SkyColour> colours,
                                       std::span<const SpectralSensitivity> cameras);

// What a camera of this sensitivity would have seen of the same skies, with what the sky was off by (`left`) on top.
std::vector<SkyColour> seen_by(const SpectralSensitivity& sensitivity, std::span<const SkyColour> colours,
                               std::span<const glm::dvec2> left);

// A CSV that read_spectral_sensitivity reads again; `comment` becomes its first lines.
std::string csv_of(const SpectralSensitivity& sensitivity, const std::string& comment);

}  // namespace kasumi
