#include "estimator/air/attenuation.hpp"

#include <algorithm>
#include <cmath>

#include <glm/matrix.hpp>

#include "calib/colour/colorimetry.hpp"

namespace kasumi {
namespace {

// Metres of sea-level density along a straight path: distance * mean of exp(-h / scale height) over it.
double density_weighted(double from_m, double to_m, double distance_m, double scale_height_m) {
  const double rise = (to_m - from_m) / scale_height_m;
  // expm1 keeps the quotient exact down to the level path, where it is 0 / 0.
  const double mean = std::abs(rise) < 1e-12 ? 1.0 : -std::expm1(-rise) / rise;
  return distance_m * std::exp(-from_m / scale_height_m) * mean;
}

SpectralMeasure normalised(SpectralMeasure measure) {
  glm::dvec3 sum{0.0};
  for (const auto& weight : measure.weight) sum += weight;
  for (auto& weight : measure.weight) {
    for (int c = 0; c < 3; ++c) weight[c] = sum[c] > 0.0 ? weight[c] / sum[c] : 0.0;
  }
  return measure;
}

template <class WeightAt>
SpectralMeasure sampled(WeightAt weight_at) {
  SpectralMeasure measure;
  for (double nm = kFirstVisible_nm; nm <= kLastVisible_nm; nm += 1.0) measure.weight.push_back(weight_at(nm));
  return normalised(std::move(measure));
}

}  // namespace

OpticalPath optical_path(double observer_altitude_m, double target_altitude_m, double distance_m) {
  return {density_weighted(observer_altitude_m, target_altitude_m, distance_m, kRayleighScaleHeight_m),
          density_weighted(observer_altitude_m, target_altitude_m, distance_m, kMieScaleHeight_m)};
}

SpectralMeasure spectral_measure(const SpectralSensitivity& sensitivity) {
  return sampled([&](double nm) { return sensitivity.at(nm); });
}

SpectralMeasure spectral_measure(const Camera& camera) {
  if (camera.colour_space == Camera::ColourSpace::sensor) return spectral_measure(camera.sensitivity);
  const glm::dmat3 to_srgb = glm::inverse(srgb_to_xyz()) * camera_to_xyz(camera.sensitivity);
  return sampled([&](double nm) { return to_srgb * camera.sensitivity.at(nm); });
}

glm::dvec3 attenuation_reference(const SpectralMeasure& measure, ScatteringModel model, const AirState& air,
                                 const OpticalPath& path) {
  glm::dvec3 gamma{0.0};
  for (std::size_t i = 0; i < measure.weight.size(); ++i) {
    const double nm = measure.first_nm + static_cast<double>(i);
    const double depth = rayleigh_per_m(model, nm) * path.rayleigh_m + mie_per_m(model, nm, air) * path.mie_m;
    gamma += measure.weight[i] * std::exp(-depth);
  }
  return gamma;
}

HazeCoefficients haze_coefficients(const AttenuationNodes& nodes, ScatteringModel model, const AirState& air) {
  HazeCoefficients haze;
  haze.weight = nodes.weight;
  for (std::size_t k = 0; k < kAttenuationNodes; ++k) {
    for (int c = 0; c < 3; ++c) {
      haze.rayleigh_per_m[k][c] = rayleigh_per_m(model, nodes.wavelength_nm[k][c]);
      haze.mie_per_m[k][c] = mie_per_m(model, nodes.wavelength_nm[k][c], air);
    }
  }
  return haze;
}

glm::dvec3 attenuation(const HazeCoefficients& haze, const OpticalPath& path) {
  glm::dvec3 gamma{0.0};
  for (std::size_t k = 0; k < kAttenuationNodes; ++k) {
    for (int c = 0; c < 3; ++c) {
      gamma[c] += haze.weight[k][c] *
                  std::exp(-haze.rayleigh_per_m[k][c] * path.rayleigh_m - haze.mie_per_m[k][c] * path.mie_m);
    }
  }
  return gamma;
}

}  // namespace kasumi
