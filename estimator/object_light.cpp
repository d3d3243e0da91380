#include "estimator/object_light.hpp"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/matrix.hpp>

#include "calib/colorimetry.hpp"
#include "estimator/airlight.hpp"

namespace kasumi {
namespace {

constexpr double kLumensPerWatt = 683.0;
// Preetham's zenith luminance reaches zero with the sun still 2-3 deg up; a real sky keeps some 200 cd/m2 until sunset.
constexpr double kDarkestZenith_cd_m2 = 200.0;
constexpr double kSunRadius_deg = 0.2666;

double visible_share_of_sun(Radians zenith) {
  const double elevation_deg = 90.0 - to_degrees(zenith);
  return std::clamp(0.5 + 0.5 * elevation_deg / kSunRadius_deg, 0.0, 1.0);
}

// Krochmann and Seidl's zenith of the overcast sky, cd m-2.
double overcast_zenith(const SunDirection& sun) {
  return 123.0 + 8600.0 * std::max(0.0, sun.z);
}

}  // namespace

Daylight::Daylight(const Camera& scene, Turbidity turbidity, const SunDirection& sun, const DaylightOptions& options)
    : options_(options), sun_(sun), model_(turbidity, raised_to_horizon(sun)) {
  const bool overcast = options.sky == SkyCondition::overcast;
  zenith_cd_m2_ = overcast ? overcast_zenith(sun) : std::max(kDarkestZenith_cd_m2, 1000.0 * model_.zenith_luminance());

  // Daylight spectra span three dimensions, so XYZ gives their spectrum and that the sensor's channels.
  const glm::dmat3 xyz_to_sensor = glm::inverse(camera_to_xyz(scene.sensitivity)) / kLumensPerWatt;
  const bool srgb = scene.colour_space == Camera::ColourSpace::srgb;
  xyz_to_light_ = srgb ? glm::inverse(srgb_to_xyz()) / kLumensPerWatt : xyz_to_sensor;
  const glm::dmat3 sensor_to_light = xyz_to_light_ * glm::inverse(xyz_to_sensor);  // identity for a sensor

  if (!srgb) light_.albedo_to_channels = srgb_reflectance_to_channels(scene.sensitivity);
  light_.sun_direction = sun;
  const Radians zenith = zenith_angle(sun);
  const double sun_share = overcast ? 0.0 : visible_share_of_sun(zenith);
  if (sun_share > 0.0) {
    glm::dvec3 on_sensor{0.0};
    for (double nm = kFirstVisible_nm; nm <= kLastVisible_nm; nm += 1.0) {
      const double power =
          sun_share * solar_irradiance(nm) * sun_transmittance(model_.turbidity(), zenith, options.altitude_m, nm);
      on_sensor += power * scene.sensitivity.at(nm);
      sun_normal_lux_ += kLumensPerWatt * power * colour_matching(nm).y;
    }
    light_.sun_irradiance = glm::max(sensor_to_light * on_sensor, glm::dvec3{0.0});
  }

  const Direction up{0.0, 0.0, 1.0};
  const auto sky = sky_harmonics([this](const Direction& direction) { return airlight(direction); });
  sky_horizontal_lux_ =
      irradiance(sky_harmonics([this](const Direction& direction) { return sky_xyz(direction); }), up).y;
  const glm::dvec3 on_ground = irradiance(sky, up) + std::max(0.0, sun.z) * light_.sun_irradiance;
  const auto ground = ground_harmonics(options.ground_albedo / kPi * on_ground);
  for (std::size_t i = 0; i < sky.size(); ++i) light_.sky_irradiance_sh[i] = sky[i] + ground[i];
}

glm::dvec3 Daylight::sky_xyz(const Direction& direction) const {
  const Direction view = raised_to_horizon(direction);
  if (options_.sky == SkyCondition::overcast) {
    constexpr double kD65x = 0.3127, kD65y = 0.3290;
    return xyz_of({zenith_cd_m2_ * (1.0 + 2.0 * view.z) / 3.0, kD65x, kD65y});
  }
  return zenith_cd_m2_ * model_.relative_xyz(view);
}

glm::dvec3 Daylight::airlight(const Direction& direction) const {
  const glm::dvec3 xyz = sky_xyz(direction);
  // Chromaticities at the model's edge may leave the gamut of linear sRGB.
  return glm::max(xyz_to_light_ * xyz, 1e-3 * glm::abs(xyz_to_light_ * glm::dvec3{xyz.y}));
}

}  // namespace kasumi
