// What a dome supposes of the air and what another air of the same amount may have otherwise: the ground below it, and
// how its aerosol scatters into directions. Either moves a found amount by a third, so a fit must know of both.
#pragma once

#include <array>
#include <functional>
#include <span>

#include <Eigen/Core>

#include "base/aerosol.hpp"
#include "estimator/atmosphere.hpp"
#include "estimator/sky_fit/reading_patches.hpp"

namespace kasumi {

constexpr int kSkyDoubts = 2;         // the ground's albedo, and the mean cosine of the aerosol's scattering
constexpr double kSigmaGround = 0.2;  // of its albedo; the first doubt
// By how much ln light changes for one standard deviation of each, [place of the sky][doubt], for each channel of
// linear sRGB.
using RadianceDoubts = std::array<Eigen::MatrixXd, 3>;

// What falls on level ground, linear sRGB, lux, where the sky has the light in cd/m2.
glm::dvec3 light_on_ground(const RadianceField& sky, const glm::dvec3& sun_illuminance, const SunDirection& sun);

// `log_light`: ln of the sky's light, cd/m2, at the directions, for each channel. `brighter_ground`: about which number
// of standard deviations, since what snow sends up is no small part of the light.
RadianceDoubts sky_doubts(const Aerosol& aerosol, double altitude_m, const SunDirection& sun,
                          std::span<const Direction> directions, const std::array<Eigen::VectorXd, 3>& log_light,
                          const glm::dvec3& on_ground, double brighter_ground);

}  // namespace kasumi
