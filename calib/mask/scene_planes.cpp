#include "calib/mask/scene_planes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/geometry.hpp"
#include "base/table/config_table.hpp"

namespace kasumi {

namespace {

constexpr Range kDistances_m{0.5, 400e3};
constexpr Range kAzimuths_deg{-360.0, 720.0};

SceneWall read_wall(const ConfigTable& table) {
  SceneWall wall;
  wall.distance_m = table.number("distance_m", kDistances_m);
  wall.faces = from_degrees(table.number("azimuth_deg", kAzimuths_deg, 0.0));
  if (table.has("from_deg") != table.has("to_deg")) table.problem("from_deg", "it together with to_deg, or neither");
  if (table.has("from_deg")) wall.from = from_degrees(table.number("from_deg", kAzimuths_deg));
  if (table.has("to_deg")) wall.to = from_degrees(table.number("to_deg", kAzimuths_deg));
  if (table.has("top_m")) wall.top_m = table.number("top_m", {-5e3, 9e3});
  return wall;
}

// Clockwise from one to the other, as 0 .. 2 pi.
double turn(Radians from, Radians to) {
  const double angle = std::fmod(to.value - from.value, 2.0 * kPi);
  return angle < 0.0 ? angle + 2.0 * kPi : angle;
}

double distance_to(const SceneWall& wall, const Direction& direction) {
  constexpr double kNowhere = std::numeric_limits<double>::infinity();
  if (wall.from && wall.to && turn(*wall.from, azimuth_angle(direction)) > turn(*wall.from, *wall.to)) return kNowhere;
  const double towards = direction.x * std::sin(wall.faces.value) + direction.y * std::cos(wall.faces.value);
  if (!(towards > 1e-6)) return kNowhere;
  const double distance_m = wall.distance_m / towards;
  return wall.top_m && distance_m * direction.z > *wall.top_m ? kNowhere : distance_m;
}

}  // namespace

bool ScenePlanes::sky_from_picture() const {
  return std::any_of(walls.begin(), walls.end(), [](const SceneWall& wall) { return !wall.top_m; });
}

Result<ScenePlanes> read_scene_planes(const std::filesystem::path& path) {
  const auto root = ConfigTable::read_file(path);
  if (!root) return fail(root.error());
  ScenePlanes planes;
  if (root->has("camera_height_m")) planes.camera_height_m = root->number("camera_height_m", {0.1, 9000.0});
  for (const auto& table : root->tables("walls")) planes.walls.push_back(read_wall(table));
  if (!planes.camera_height_m && planes.walls.empty())
    root->problem("walls", "camera_height_m over a level ground, or [[walls]], or both");
  if (auto done = root->finish(); !done) return fail(done.error());
  return planes;
}

Image<float> distances_to(const ScenePlanes& planes, const Camera& camera) {
  Image<float> distances_m(camera.width, camera.height, 0.0F);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const auto direction = camera.direction_at({x, y});
      if (!direction) continue;
      double nearest_m = std::numeric_limits<double>::infinity();
      if (planes.camera_height_m && direction->z < 0.0) nearest_m = *planes.camera_height_m / -direction->z;
      for (const auto& wall : planes.walls) nearest_m = std::min(nearest_m, distance_to(wall, *direction));
      if (std::isfinite(nearest_m)) distances_m.at(x, y) = static_cast<float>(std::min(nearest_m, 400e3));
    }
  return distances_m;
}

}  // namespace kasumi
