#include "estimator/sky/site_sky.hpp"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>

#include "base/geometry.hpp"

namespace kasumi {

std::string_view name_of(DaylightModel model) {
  switch (model) {
    case DaylightModel::automatic: return "automatic";
    case DaylightModel::preetham: return "preetham";
    case DaylightModel::dome: return "dome";
  }
  return "automatic";
}

std::optional<DaylightModel> daylight_model_named(std::string_view name) {
  for (const auto model : {DaylightModel::automatic, DaylightModel::preetham, DaylightModel::dome})
    if (name == name_of(model)) return model;
  return std::nullopt;
}

DaylightModel resolved(DaylightModel model, double altitude_m, bool aerosol_known) {
  if (model != DaylightModel::automatic) return model;
  return aerosol_known || altitude_m > kHighestPreethamSite_m ? DaylightModel::dome : DaylightModel::preetham;
}

namespace {

double dome_share_under(const SunDirection& sun) {
  const double elevation = 0.5 * kPi - zenith_angle(sun).value;
  const double above = (elevation - kDomeAloneBelow.value) / (kPreethamAloneAbove.value - kDomeAloneBelow.value);
  const double u = std::clamp(1.0 - above, 0.0, 1.0);
  return u * u * (3.0 - 2.0 * u);
}

}  // namespace

SiteSky::SiteSky(DaylightModel model, const AirState& air, const SunDirection& sun, double altitude_m) {
  if (resolved(model, altitude_m, air.aerosol_known()) == DaylightModel::dome) {
    dome_share_ = 1.0;
  } else {
    preetham_.emplace(air.turbidity(), raised_to_horizon(sun));
    if (model == DaylightModel::automatic) dome_share_ = dome_share_under(sun);
  }
  if (dome_share_ <= 0.0) return;
  Dome dome{kasumi::dome(altitude_m, air.aerosol(), sun), 1.0, dome_sun(altitude_m, air.aerosol(), sun).illuminance};
  dome.zenith_cd_m2 = std::max(dome_light(dome.light, {0.0, 0.0, 1.0}).y, 1e-9);
  dome_ = dome;
}

glm::dvec3 SiteSky::relative_xyz(const Direction& view) const {
  const auto of_preetham = [&] { return preetham_->relative_xyz(raised_to_horizon(view)); };
  if (dome_share_ <= 0.0) return of_preetham();
  const glm::dvec3 of_dome = glm::max(dome_light(dome_->light, view), glm::dvec3{0.0}) / dome_->zenith_cd_m2;
  return dome_share_ < 1.0 ? glm::mix(of_preetham(), of_dome, dome_share_) : of_dome;
}

std::optional<double> SiteSky::zenith_cd_m2() const {
  return dome_ ? std::optional(dome_->zenith_cd_m2) : std::nullopt;
}

std::optional<glm::dvec3> SiteSky::sun_xyz() const {
  return dome_ ? std::optional(dome_->sun_xyz) : std::nullopt;
}

}  // namespace kasumi
