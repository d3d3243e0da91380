// A camera's response to daylight: its sensitivity in bands, and the colours it records of the sky's spectra.
#pragma once

#include <array>

#include <Eigen/Core>
#include <glm/vec2.hpp>

#include "calib/colour/colorimetry.hpp"
#include "calib/colour/spectral_sensitivity.hpp"

namespace kasumi {

constexpr int kBands = 81;
constexpr double kBandStep_nm = 5.0;
double band_nm(int i);  // from kFirstVisible_nm on

// One channel's sensitivity at the bands, linear between them; its mean is 1.
using BandCurve = Eigen::Matrix<double, kBands, 1>;
BandCurve curve_of(const SpectralSensitivity& sensitivity, int channel);
std::array<BandCurve, 3> curves_of(const SpectralSensitivity& sensitivity);

// Sums over 1 nm of what a curve sees of S0, S1, S2: one column each.
const Eigen::Matrix<double, kBands, 3>& daylight_sums();

// All that daylight can reveal about a camera: per channel the integrals of q S1 and q S2 over that of q S0.
using DaylightResponse = Eigen::Matrix<double, 6, 1>;
DaylightResponse daylight_response_of(const std::array<BandCurve, 3>& curves);

// ln of a channel's light of a spectrum over that of S0.
double log_response(const DaylightResponse& response, int channel, const DaylightWeights& spectrum);
// ln(red / green), ln(blue / green); gains are not in them.
constexpr std::array kAgainstGreen{0, 2};  // channels of the two log ratios
glm::dvec2 log_ratios(const DaylightResponse& response, const DaylightWeights& spectrum);

}  // namespace kasumi
