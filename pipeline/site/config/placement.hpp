// Where the virtual building stands.
#pragma once

#include <filesystem>
#include <string>

#include <glm/vec3.hpp>

#include "base/table/config_table.hpp"
#include "calib/camera.hpp"
#include "estimator/light/skyline.hpp"
#include "gles/model/model.hpp"

namespace kasumi {

struct ObjectPlacement {
  std::filesystem::path model;
  std::string scene;  // of the model's scenes (eras), by name or number; empty: its default
  Placement placement;
  bool shadows = true;  // of the sun, on itself and on the model's own ground
  // The shadow on the real ground is drawn: where it lies in the shade already, and the sky light that it loses.
  bool ground_light = false;
  Skyline skyline;  // behind which the sun goes down for the object
};

// East, north, up (metres) of a place as seen from the site, in the site's tangent plane on the WGS 84 ellipsoid:
// the earth's curvature lowers distant places (by 1 m at 3.6 km).
glm::dvec3 east_north_up(const Site& site, double latitude_deg, double longitude_deg, double altitude_m);

// How much refraction lifts the apparent position of a place, metres: k d^2 / 2R with the coefficient of refraction k,
// .13 by day over land (geodesy's mean since Gauss), 0 for none. 13 cm at 3.5 km, 4 m at 20 km.
constexpr double kUsualRefraction = 0.13;
double lift_by_refraction(double distance_m, double coefficient = kUsualRefraction);

// [object]: model, scene, east_m north_m up_m or latitude_deg longitude_deg altitude_m (then refraction, default .13,
// lifts it), heading_deg, scale, up, shadows, ground_light, skyline. Problems are collected in the table's file.
ObjectPlacement read_placement(const ConfigTable& table, const Site& site);

}  // namespace kasumi
