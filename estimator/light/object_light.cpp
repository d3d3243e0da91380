#include "estimator/light/object_light.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "base/geometry.hpp"
#include "base/sky/sun_disc.hpp"
#include "base/statistics.hpp"
#include "calib/colour/colorimetry.hpp"

namespace kasumi {
namespace {

const Direction kUp{0.0, 0.0, 1.0};

double visible_share_of_sun(Radians zenith) {
  const double elevation_deg = 90.0 - to_degrees(zenith);
  return std::clamp(0.5 + 0.5 * elevation_deg / kSettingSunRadius_deg, 0.0, 1.0);
}

// Zenith luminance of a sky with the model's distribution and horizontal illuminance `lux`.
double zenith_for(const SiteSky& model, double lux) {
  constexpr int kZeniths = 60, kAzimuths = 72;  // cells of 5 deg: the aureole is no edge at that size
  double per_zenith = 0.0;
  for (int i = 0; i < kZeniths; ++i) {
    // Uniform steps of cos^2, which have equal weight on the ground, so that a uniform sky is exact.
    const Radians zenith{std::acos(std::sqrt((i + 0.5) / kZeniths))};
    for (int j = 0; j < kAzimuths; ++j)
      per_zenith += model.relative_xyz(direction_from(zenith, {(j + 0.5) * 2.0 * kPi / kAzimuths})).y;
  }
  return lux / (per_zenith * kPi / (kZeniths * kAzimuths));
}

// Krochmann and Seidl's zenith of the overcast sky, cd m-2.
double overcast_zenith(const SunDirection& sun) {
  return 123.0 + 8600.0 * std::max(0.0, sun.z);
}

}  // namespace

Daylight::Daylight(const Camera& scene, const AirState& air, const SunDirection& sun, const DaylightConditions& options)
    : options_(options),
      sun_(sun),
      turbidity_(clamp_turbidity(air.turbidity())),
      model_(options.model, air, sun, options.altitude_m),
      zenith_cd_m2_(zenith_luminance()) {
  // Daylight spectra span three dimensions, so XYZ determines their spectrum, and the spectrum the sensor's channels.
  const glm::dmat3 xyz_to_sensor = glm::inverse(camera_to_xyz(scene.sensitivity)) / kLuminousEfficacy;
  const bool srgb = scene.colour_space == Camera::ColourSpace::srgb;
  xyz_to_light_ = srgb ? glm::inverse(srgb_to_xyz()) / kLuminousEfficacy : xyz_to_sensor;
  const glm::dmat3 sensor_to_light = xyz_to_light_ * glm::inverse(xyz_to_sensor);  // identity for a sensor

  if (!srgb) light_.albedo_to_channels = srgb_reflectance_to_channels(scene.sensitivity);
  light_.sun_direction = sun;
  glow_by_ground(air.aerosol());
  const auto unit = options.measured ? unit_of(*options.measured) : std::nullopt;
  light_by_sun(scene.sensitivity, sensor_to_light, options.past_hills * (unit ? options.measured->sun_share : 1.0));
  light_by_sky(unit);
  light_by_ground();
}

double Daylight::zenith_luminance() const {
  if (is_overcast()) return overcast_zenith(sun_);
  const double share = model_.dome_share();
  if (share >= 1.0) return *model_.zenith_cd_m2();
  const double of_preetham =
      zenith_for(model_, clear_sky_lux(turbidity_, zenith_angle(sun_), options_.altitude_m, options_.ground_albedo));
  return share > 0.0 ? std::lerp(of_preetham, *model_.zenith_cd_m2(), share) : of_preetham;
}

void Daylight::glow_by_ground(const Aerosol& aerosol) {
  if (is_overcast() || model_.dome_share() <= 0.0 || options_.ground_albedo == kDomeGroundAlbedo) return;
  constexpr int kZeniths = 16, kAzimuths = 24;  // of a correction by the ground, which is smooth
  glm::dvec3 lit = std::max(0.0, sun_.z) * *model_.sun_xyz();
  for (int i = 0; i < kZeniths; ++i)  // even steps of cos^2 weigh the same on the ground
    for (int j = 0; j < kAzimuths; ++j)
      lit += sky_xyz(direction_from(Radians{std::acos(std::sqrt((i + 0.5) / kZeniths))},
                                    Radians{(j + 0.5) * 2.0 * kPi / kAzimuths})) *
             (kPi / (kZeniths * kAzimuths));
  glow_.emplace(aerosol, options_.altitude_m, options_.ground_albedo, xyz_to_linear_srgb() * lit);
}

void Daylight::light_by_sun(const SpectralSensitivity& sensor, const glm::dmat3& sensor_to_light, double reaching) {
  if (is_overcast() || !(reaching > 0.0)) return;
  const double of_dome = model_.dome_share();
  if (of_dome > 0.0) {  // which knows how much of the disc is above the horizon
    const glm::dvec3 xyz = of_dome * reaching * *model_.sun_xyz();
    light_.sun_irradiance = glm::max(xyz_to_light_ * xyz, glm::dvec3{0.0});
    sun_normal_lux_ = xyz.y;
  }
  const Radians zenith = zenith_angle(sun_);
  const double share = (1.0 - of_dome) * reaching * visible_share_of_sun(zenith);
  if (!(share > 0.0)) return;
  glm::dvec3 on_sensor{0.0};
  for (double nm = kFirstVisible_nm; nm <= kLastVisible_nm; nm += 1.0) {
    const double power = share * solar_irradiance(nm) * sun_transmittance(turbidity_, zenith, options_.altitude_m, nm);
    on_sensor += power * sensor.at(nm);
    sun_normal_lux_ += kLuminousEfficacy * power * colour_matching(nm).y;
  }
  light_.sun_irradiance += glm::max(sensor_to_light * on_sensor, glm::dvec3{0.0});
}

glm::dvec3 Daylight::seen_xyz(const Direction& direction, const std::optional<glm::dvec3>& unit) const {
  const glm::dvec3 model = sky_xyz(direction);
  if (!unit) return model;
  const MeasuredCell& cell = options_.measured->at(direction);
  const glm::dvec3 seen = *unit * cell.xyz;
  // Clear air keeps the model's light, which has the finer resolution. A clipped value is a lower bound of the
  // brightness.
  return glm::mix(model, cell.clipped ? glm::max(model, seen) : seen,
                  is_overcast() ? cell.seen : cell.seen * (1.0 - cell.clear));
}

void Daylight::light_by_sky(const std::optional<glm::dvec3>& unit) {
  light_.around =
      light_around_of([&](const Direction& d) { return d.z > 0.0 ? light_of(seen_xyz(d, unit)) : glm::dvec3{0.0}; });
  sky_horizontal_lux_ = (glm::inverse(xyz_to_light_) * irradiance(light_.around, kUp)).y;
}

// The surrounding ground reflects the light it receives diffusely; texels at the horizon contain both ground and sky.
void Daylight::light_by_ground() {
  const glm::dvec3 falls = irradiance(light_.around, kUp) + std::max(0.0, sun_.z) * light_.sun_irradiance;
  const glm::dvec3 ground = options_.ground_albedo / kPi * falls;
  const auto below = light_around_of([&](const Direction& d) { return d.z > 0.0 ? glm::dvec3{0.0} : ground; });
  auto& radiance = light_.around.radiance.elements();
  for (std::size_t i = 0; i < radiance.size(); ++i) radiance[i] += below.radiance.elements()[i];
}

std::optional<glm::dvec3> Daylight::unit_of(const MeasuredSky& measured) const {
  constexpr std::size_t kLeastCells = 8;  // of each channel: a median of fewer follows a single cloud
  const double not_near_sun = std::cos(from_degrees(20.0).value), not_low = std::cos(from_degrees(80.0).value);
  std::array<std::vector<double>, 3> ratios;
  for (int ring = 0; ring < MeasuredSky::kRings; ++ring)
    for (int sector = 0; sector < MeasuredSky::kSectors; ++sector) {
      const Direction centre = MeasuredSky::centre_of(ring, sector);
      const MeasuredCell& cell = measured.at(centre);
      const bool same = is_overcast() || cell.clear > 0.9;
      if (!same || cell.clipped || cell.seen < 0.5 || centre.z < not_low) continue;
      if (!is_overcast() && glm::dot(centre, sun_) > not_near_sun) continue;
      if (!(std::min({cell.xyz.x, cell.xyz.y, cell.xyz.z}) > 0.0)) continue;
      const glm::dvec3 ratio = sky_xyz(centre) / cell.xyz;
      for (int c = 0; c < 3; ++c) ratios[static_cast<std::size_t>(c)].push_back(ratio[c]);
    }
  if (ratios[0].size() < kLeastCells) return std::nullopt;
  glm::dvec3 unit;
  for (int c = 0; c < 3; ++c) unit[c] = median_in_place(ratios[static_cast<std::size_t>(c)]);
  return unit;
}

glm::dvec3 Daylight::sky_xyz(const Direction& direction) const {
  const Direction view = raised_to_horizon(direction);
  if (is_overcast()) {
    constexpr double kD65x = 0.3127, kD65y = 0.3290;  // CIE's D65, the white of a closed sky
    return xyz_of({zenith_cd_m2_ * (1.0 + 2.0 * view.z) / 3.0, kD65x, kD65y});
  }
  // A high site's horizon lies below the level, and the dome goes down to it.
  const glm::dvec3 clear = zenith_cd_m2_ * model_.relative_xyz(direction);
  return glow_ ? glm::max(clear + model_.dome_share() * (srgb_to_xyz() * glow_->radiance(view.z)), glm::dvec3{0.0})
               : clear;
}

glm::dvec3 Daylight::light_of(const glm::dvec3& xyz) const {
  // Chromaticities at the model's edge may lie outside the gamut of linear sRGB.
  return glm::max(xyz_to_light_ * xyz, 1e-3 * glm::abs(xyz_to_light_ * glm::dvec3{xyz.y}));
}

glm::dvec3 Daylight::airlight(const Direction& direction) const {
  return light_of(sky_xyz(direction));
}

}  // namespace kasumi
