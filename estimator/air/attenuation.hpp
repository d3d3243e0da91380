// What is left of light after a path through the air, per camera channel (M Eq 11; physics 4).
#pragma once

#include <array>
#include <vector>

#include <glm/vec3.hpp>

#include "calib/camera.hpp"
#include "calib/colour/colorimetry.hpp"
#include "calib/colour/spectral_sensitivity.hpp"
#include "estimator/air/scattering.hpp"
#include "estimator/atmosphere.hpp"

namespace kasumi {

// A path's length weighted by the density of air and of haze relative to sea level: optical depth is the sea-level
// coefficient times this. Exact for slanted straight paths over a flat earth (the earth's curvature lowers a path of
// 50 km by 49 m in its middle, 4 % of the haze's scale height).
struct OpticalPath {
  double rayleigh_m = 0.0;
  double mie_m = 0.0;
};
// Altitudes above sea level of the path's ends and its length, in metres.
OpticalPath optical_path(double observer_altitude_m, double target_altitude_m, double distance_m);

// The weight of each wavelength in a channel, every nanometre from first_nm; each channel sums to 1. Weights may be
// negative: linear sRGB is a mix of the sensor's channels with negative terms.
struct SpectralMeasure {
  double first_nm = kFirstVisible_nm;
  std::vector<glm::dvec3> weight;
};
// As in M Eq 11: the spectral sensitivity q_c.
SpectralMeasure spectral_measure(const SpectralSensitivity& sensitivity);
// For the channels the camera delivers: q_c, or its mix into linear sRGB when the camera converts. The difference
// matters: M's q_c on sRGB channels is off by up to 12 of 255 (mean 2-3 on dark surfaces), the mix by 1-2 (.3).
SpectralMeasure spectral_measure(const Camera& camera);
// Gamma at 1 nm in double precision: slow, used as the reference.
glm::dvec3 attenuation_reference(const SpectralMeasure& measure, ScatteringModel model, const AirState& air,
                                 const OpticalPath& path);

// Quadrature nodes of a measure, similar to Gauss nodes but with the smallest worst error over T 1.7-20 and paths to 50
// km. They depend on the sensor alone, so a new turbidity changes only 2 coefficients per node. Worst error over all
// cameras whose data Kasumi has: 2.6e-4 for M's q_c (Gauss nodes in 1 / wavelength 7e-4), 6e-4 for its mix into sRGB.
constexpr int kAttenuationNodes = 2;
struct AttenuationNodes {
  std::array<glm::dvec3, kAttenuationNodes> weight{};  // each channel's sum is 1
  std::array<glm::dvec3, kAttenuationNodes> wavelength_nm{};
};
// Deterministic; takes some milliseconds.
AttenuationNodes attenuation_nodes(const SpectralMeasure& measure);
// The same for ScatteringModel::aerosol, whose extinction follows another law of wavelength: nodes of one Angstrom
// exponent, which an exponent off by .1 costs some 1e-4 (physics 12).
AttenuationNodes attenuation_nodes(const SpectralMeasure& measure, double angstrom_exponent);
// Those that a model needs under an air.
AttenuationNodes attenuation_nodes(const SpectralMeasure& measure, ScatteringModel model, const AirState& air);

// The nodes' coefficients at sea level for one air, as the renderer's Haze needs them.
struct HazeCoefficients {
  std::array<glm::dvec3, kAttenuationNodes> weight{};
  std::array<glm::dvec3, kAttenuationNodes> rayleigh_per_m{};
  std::array<glm::dvec3, kAttenuationNodes> mie_per_m{};
};
HazeCoefficients haze_coefficients(const AttenuationNodes& nodes, ScatteringModel model, const AirState& air);
glm::dvec3 attenuation(const HazeCoefficients& haze, const OpticalPath& path);

}  // namespace kasumi
