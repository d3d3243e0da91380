#include "pipeline/site/config/placement.hpp"

#include <cmath>

#include "base/earth.hpp"
#include "pipeline/site/config/read_skyline.hpp"

namespace kasumi {

namespace {

glm::dvec3 earth_centred(double latitude_deg, double longitude_deg, double altitude_m) {
  const double latitude = from_degrees(latitude_deg).value, longitude = from_degrees(longitude_deg).value;
  const double e2 = kWgs84Flattening * (2.0 - kWgs84Flattening);
  const double s = std::sin(latitude), c = std::cos(latitude);
  const double n = kWgs84SemiMajorAxis_m / std::sqrt(1.0 - e2 * s * s);
  return {(n + altitude_m) * c * std::cos(longitude), (n + altitude_m) * c * std::sin(longitude),
          (n * (1.0 - e2) + altitude_m) * s};
}

}  // namespace

glm::dvec3 east_north_up(const Site& site, double latitude_deg, double longitude_deg, double altitude_m) {
  const glm::dvec3 offset = earth_centred(latitude_deg, longitude_deg, altitude_m) -
                            earth_centred(site.latitude_deg, site.longitude_deg, site.altitude_m);
  const double latitude = from_degrees(site.latitude_deg).value, longitude = from_degrees(site.longitude_deg).value;
  const double sp = std::sin(latitude), cp = std::cos(latitude), sl = std::sin(longitude), cl = std::cos(longitude);
  return {-sl * offset.x + cl * offset.y, -sp * cl * offset.x - sp * sl * offset.y + cp * offset.z,
          cp * cl * offset.x + cp * sl * offset.y + sp * offset.z};
}

double lift_by_refraction(double distance_m, double coefficient) {
  return coefficient * distance_m * distance_m / (2.0 * kEarthRadius_m);
}

ObjectPlacement read_placement(const ConfigTable& table, const Site& site) {
  ObjectPlacement object;
  object.model = table.file("model");
  object.scene = table.text("scene", "");
  const bool geographic = table.has("latitude_deg") || table.has("longitude_deg") || table.has("altitude_m");
  const bool local = table.has("east_m") || table.has("north_m") || table.has("up_m");
  if (geographic && local)
    table.problem("latitude_deg",
                  "a place given once: east_m, north_m, up_m or latitude_deg, longitude_deg, altitude_m, not both");
  glm::dvec3 place;
  if (geographic) {
    place = east_north_up(site, table.number("latitude_deg", {-90, 90}), table.number("longitude_deg", {-180, 180}),
                          table.number("altitude_m", {-500, 9000}));
    place.z += lift_by_refraction(std::hypot(place.x, place.y), table.number("refraction", {-1, 1}, kUsualRefraction));
  } else {
    constexpr Range kWithinSight{-200e3, 200e3};
    place = {table.number("east_m", kWithinSight), table.number("north_m", kWithinSight),
             table.number("up_m", {-9000, 9000})};
  }
  object.placement = {place.x, place.y, place.z, from_degrees(table.number("heading_deg", {-360, 360}, 0.0)),
                      table.number("scale", {1e-4, 1e4}, 1.0)};
  if (table.choice("up", {"y", "z"}, "y") == "z") object.placement.up_axis = UpAxis::z;
  object.shadows = table.flag("shadows", true);
  object.ground_light = table.flag("ground_light", false);
  object.skyline = read_skyline(table);
  return object;
}

}  // namespace kasumi
