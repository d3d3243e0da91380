// Spectral sensitivity of a camera's channels, and the colours of sky light and surfaces that follow from it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "base/result.hpp"

namespace kasumi {

// q_c(lambda): relative response of the three channels, evenly spaced wavelengths.
struct SpectralSensitivity {
  std::string name;
  double first_nm = 380.0;
  double step_nm = 5.0;
  std::vector<glm::dvec3> samples;  // R, G, B
  double last_nm() const { return first_nm + step_nm * static_cast<double>(samples.size() - 1); }
  glm::dvec3 at(double wavelength_nm) const;  // linear between samples, zero outside
};

// The ACES community's rawtoaces JSON, or a CSV of wavelength and three columns (header names R, G, B in any order; a
// fourth is ignored; percent or fractions; uneven steps are resampled). Each is normalised so that the largest sample
// is 1.
Result<SpectralSensitivity> read_spectral_sensitivity(const std::filesystem::path& path);
// Three smooth bells around 600, 540 and 450 nm: the default for a camera without a data sheet.
SpectralSensitivity generic_sensitivity();

// XYZ of sky light from the integrals of L q_c: CIE daylight spectra span three dimensions, so that three channels
// determine XYZ of every mixture of them exactly (M Eq 7; Wyszecki and Stiles). Light is in the camera's channels after
// division by the white balance gains; XYZ are integrals over nm of the same L, 380-780 nm at 1 nm, without 683 lm/W.
glm::dmat3 camera_to_xyz(const SpectralSensitivity& sensitivity);
// Whether the three channels see sky light differently enough for camera_to_xyz; a grey camera's do not.
bool separates_daylight(const SpectralSensitivity& sensitivity);
// What the camera's channels see of a surface that is given by its linear sRGB colour (a model's texture): reflectance
// per channel = matrix * linear sRGB. The surface's spectrum is taken to be the smoothest one of that colour under D65
// (least squared differences between neighbouring wavelengths; Meng et al. 2015, without their bounds, so that it is
// linear); white stays white. Saturated colours may leave 0..1.
glm::dmat3 srgb_reflectance_to_channels(const SpectralSensitivity& sensitivity);

}  // namespace kasumi
