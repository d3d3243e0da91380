// The clear sky's light near the horizon across the view, also when clouds stand in front of it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <glm/vec3.hpp>

namespace kasumi {

// A small patch of sky in the scene's picture. Angles from the middle of the view, radians.
struct HorizonCell {
  double azimuth = 0.0;
  double elevation = 0.0;
  glm::dvec3 log_light{0};  // natural logarithm of the light
  double noise = 0.0;       // of log_light, 1 sigma of the worst channel, the encoding's steps included
  int strip = 0;            // of the view, from the left
};

// Logarithm of light as a quadratic in azimuth and elevation, channel by channel.
struct ClearHorizon {
  double coefficients[3][5]{};  // of 1, azimuth, azimuth^2, elevation, elevation^2
  double tolerance = 0.0;       // of log light: cells farther than this from the surface are not clear sky
  double share = 0.0;           // of the fitted cells that are clear sky by that tolerance

  glm::dvec3 log_light(double azimuth, double elevation) const;
  glm::dvec3 residual(const HorizonCell& cell) const;  // log_light of the cell minus the surface's
  bool is_clear(const HorizonCell& cell) const;
};

// The smooth surface that most cells lie on. Clear air is uniform but for noise and slow gradients, while clouds differ
// from each other as much as from it: the fit starts at the fullest narrow window of light and grows from there by
// reweighted least squares. Only `cells` whose `use` is not 0 are used. Empty with fewer than 16 of them, or when they
// are too noisy.
std::optional<ClearHorizon> fit_clear_horizon(const std::vector<HorizonCell>& cells,
                                              const std::vector<std::uint8_t>& use);

}  // namespace kasumi
