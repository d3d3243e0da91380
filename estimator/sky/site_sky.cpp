#include "estimator/sky/site_sky.hpp"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>

#include "base/geometry.hpp"

namespace kasumi {

std::string_view name_of(SiteSkyModel model) {
  switch (model) {
    case SiteSkyModel::automatic: return "automatic";
    case SiteSkyModel::preetham: return "preetham";
    case SiteSkyModel::dome: return "dome";
  }
  return "automatic";
}

std::optional<SiteSkyModel> site_sky_model_named(std::string_view name) {
  for (const auto model : {SiteSkyModel::automatic, SiteSkyModel::preetham, SiteSkyModel::dome})
    if (name == name_of(model)) return model;
  return std::nullopt;
}

SiteSkyModel resolved(SiteSkyModel model, double altitude_m) {
  if (model != SiteSkyModel::automatic) return model;
  return altitude_m > kHighestPreethamSite_m ? SiteSkyModel::dome : SiteSkyModel::preetham;
}

SiteSky::SiteSky(SiteSkyModel model, Turbidity turbidity, const SunDirection& sun, double altitude_m)
    : sky_(SkyModel(turbidity, raised_to_horizon(sun))) {
  if (resolved(model, altitude_m) == SiteSkyModel::preetham) return;
  Dome dome{kasumi::dome(altitude_m, turbidity, sun), 1.0, dome_sun(altitude_m, turbidity, sun).illuminance};
  dome.zenith_cd_m2 = std::max(dome_light(dome.light, {0.0, 0.0, 1.0}).y, 1e-9);
  sky_ = dome;
}

glm::dvec3 SiteSky::relative_xyz(const Direction& view) const {
  if (const SkyModel* model = preetham()) return model->relative_xyz(raised_to_horizon(view));
  const Dome& dome = std::get<Dome>(sky_);
  return glm::max(dome_light(dome.light, view), glm::dvec3{0.0}) / dome.zenith_cd_m2;
}

std::optional<double> SiteSky::zenith_cd_m2() const {
  const Dome* dome = std::get_if<Dome>(&sky_);
  return dome ? std::optional(dome->zenith_cd_m2) : std::nullopt;
}

std::optional<glm::dvec3> SiteSky::sun_xyz() const {
  const Dome* dome = std::get_if<Dome>(&sky_);
  return dome ? std::optional(dome->sun_xyz) : std::nullopt;
}

}  // namespace kasumi
