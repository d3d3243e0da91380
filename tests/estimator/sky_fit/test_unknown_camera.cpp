// Skies of the model's own through cameras that bend light and lose it at the rim: whether what is not known of a camera
// is found, and stays in the sigmas. Skies that are not the model's: test_air_truth_found.
#include <cmath>

#include <gtest/gtest.h>

#include <glm/exponential.hpp>

#include "calib/colour/colorimetry.hpp"
#include "estimator/sky/dome.hpp"
#include "estimator/sky_fit/sky_family.hpp"
#include "estimator/sky_fit/unknown_camera.hpp"

namespace kasumi {
namespace {

const SunDirection kSun = direction_from(from_degrees(50.0), from_degrees(120.0));

std::vector<SkyReading> readings_by(double exponent, double rim_loss, const Aerosol& aerosol, double altitude_m = 0.0) {
  const auto sky = in_space(dome(altitude_m, aerosol, kSun), xyz_to_linear_srgb());
  std::vector<SkyReading> readings;
  constexpr int kMany = 250;
  for (int i = 0; i < kMany; ++i) {
    const Direction direction = direction_from({std::acos(0.15 + 0.85 * (i + 0.5) / kMany)}, {2.4 * i});
    if (angle_between(direction, kSun) < from_degrees(15.0)) continue;
    const double off_axis = zenith_angle(direction).value / (0.5 * kPi);
    const glm::dvec3 light = std::exp(-rim_loss * off_axis * off_axis) * dome_light(sky, direction);
    readings.push_back({direction, glm::pow(light, glm::dvec3(exponent)), glm::dvec3(0.01), off_axis});
  }
  return readings;
}

ModelToFit somewhere(double altitude_m = 0.0) {
  ModelToFit sky{DaylightModel::automatic, altitude_m};
  sky.every_model = true;
  return sky;
}

TEST(UnknownCamera, TheAirIsWithinItsSigmaWhateverTheCamera) {
  for (const Aerosol& aerosol :
       {Aerosol{0.08, 1.3, AerosolKind::continental}, Aerosol{0.3, 1.2, AerosolKind::polluted}})
    for (const double exponent : {0.75, 1.0, 1.4})
      for (const double rim_loss : {0.0, 0.4}) {
        const auto fit = fit_unknown_camera(readings_by(exponent, rim_loss, aerosol), kSun, somewhere());
        ASSERT_TRUE(fit.sky.solved);
        const double sigma = std::sqrt(fit.sky.found.covariance.aod_550);
        EXPECT_LT(std::abs(fit.sky.found.aerosol.aod_550 - aerosol.aod_550), 2.0 * sigma)
            << exponent << " " << rim_loss;
        EXPECT_LT(std::abs(fit.exponent - exponent), 3.0 * fit.sigma_exponent) << exponent << " " << rim_loss;
        EXPECT_LT(std::abs(fit.rim_loss - rim_loss), 3.0 * fit.sigma_rim_loss) << exponent << " " << rim_loss;
        EXPECT_LT(fit.sigma_exponent, 0.2);
      }
}

TEST(UnknownCamera, WhatIsKnownOfItNarrowsTheAir) {
  const auto readings = readings_by(1.3, 0.2, {0.15, 1.3, AerosolKind::continental});
  const auto unknown = fit_unknown_camera(readings, kSun, somewhere());
  const CameraBelief taught{std::log(1.3), 0.03, 0.1, 0.15, 0.0};
  const auto known = fit_unknown_camera(readings, kSun, somewhere(), taught);
  ASSERT_TRUE(unknown.sky.solved && known.sky.solved);
  EXPECT_LT(known.sky.found.covariance.aod_550, unknown.sky.found.covariance.aod_550);
  EXPECT_LT(known.sigma_exponent, unknown.sigma_exponent);
}

TEST(UnknownCamera, AnAltitudeThatNobodySaidIsPartOfTheSigma) {
  const auto readings = readings_by(1.0, 0.0, {0.1, 1.3, AerosolKind::continental}, 500.0);
  CameraBelief somewhere_up;
  somewhere_up.sigma_altitude_m = 500.0;
  const auto as_sea = fit_unknown_camera(readings, kSun, somewhere(0.0));
  const auto unsure = fit_unknown_camera(readings, kSun, somewhere(0.0), somewhere_up);
  ASSERT_TRUE(as_sea.sky.solved && unsure.sky.solved);
  EXPECT_EQ(unsure.sky.found.aerosol.aod_550, as_sea.sky.found.aerosol.aod_550);
  EXPECT_GT(unsure.sky.found.covariance.aod_550, as_sea.sky.found.covariance.aod_550);
  EXPECT_LT(std::abs(unsure.sky.found.aerosol.aod_550 - 0.1), 2.0 * std::sqrt(unsure.sky.found.covariance.aod_550));
}

TEST(UnknownCamera, NothingToSeeIsNoAnswer) {
  EXPECT_FALSE(fit_unknown_camera({}, kSun, somewhere()).sky.solved);
}

}  // namespace
}  // namespace kasumi
