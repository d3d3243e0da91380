#include "pipeline/install/calibration_report/scene_sights.hpp"

#include <cmath>

#include <glm/geometric.hpp>

#include "base/utc_text.hpp"
#include "estimator/sky/sun.hpp"
#include "pipeline/site/config/placement.hpp"

namespace kasumi {

namespace {

constexpr Range kSize_px{16.0, 16384.0};
constexpr Range kPixelSigma{0.05, 100.0}, kPlaceSigma_m{0.0, 1000.0};
constexpr double kWithinSight_m = 400e3;
constexpr double kSunDistance_m = 1.5e11, kLowestSun_deg = 0.5;

glm::dvec2 read_pixel(const ConfigTable& table, const SceneSights& sights) {
  const auto pixel = table.numbers("pixel", 2);
  const bool inside =
      pixel[0] >= -0.5 && pixel[1] >= -0.5 && pixel[0] <= sights.width - 0.5 && pixel[1] <= sights.height - 0.5;
  if (table.has("pixel") && sights.width > 0 && !inside)
    table.problem("pixel", fmt::format("[x, y] inside the {} x {} picture", sights.width, sights.height));
  return {pixel[0], pixel[1]};
}

LandmarkSight read_landmark(const ConfigTable& table, const ConfigTable& root, const SceneSights& sights) {
  LandmarkSight sight;
  sight.name = table.text("name");
  const double latitude = table.number("latitude_deg", {-90, 90}),
               longitude = table.number("longitude_deg", {-180, 180});
  sight.place_m = east_north_up(sights.site, latitude, longitude, table.number("altitude_m", {-500, 9000}));
  const double distance_m = std::hypot(sight.place_m.x, sight.place_m.y);
  if (table.has("latitude_deg") && table.has("longitude_deg") && !(distance_m <= kWithinSight_m && distance_m >= 1.0))
    table.problem("latitude_deg", fmt::format("a place 1 m to {:.0f} km from the site (it is {:.1f} km away)",
                                              kWithinSight_m / 1e3, distance_m / 1e3));
  sight.place_m.z += lift_by_refraction(distance_m, sights.refraction);
  sight.pixel = read_pixel(table, sights);
  sight.sigma_px = table.number("sigma_px", kPixelSigma, root.number("sigma_px", kPixelSigma, 1.0));
  sight.place_sigma_m = table.number("place_sigma_m", kPlaceSigma_m, root.number("place_sigma_m", kPlaceSigma_m, 1.0));
  return sight;
}

// The sun's apparent place. Near the horizon it depends on the air's temperature and pressure: 15 K or 40 hPa off the
// usual are 5 % of refraction.
LandmarkSight read_sighting(const ConfigTable& table, const ConfigTable& root, const SceneSights& sights) {
  table.choice("of", {"sun"}, std::string("sun"));
  LandmarkSight sight;
  sight.pixel = read_pixel(table, sights);
  sight.sigma_px = table.number("sigma_px", kPixelSigma, root.number("sigma_px", kPixelSigma, 1.0));
  const Utc utc = table.utc("utc");
  sight.name = "the sun, " + utc_text(utc);
  const auto sun = sun_position(utc, sights.site);
  const double elevation_deg = 90.0 - to_degrees(sun.zenith);
  if (table.has("utc") && elevation_deg < kLowestSun_deg)
    table.problem("utc",
                  fmt::format("a time at which the sun is up (it stood {:.1f} deg above the horizon of the site)",
                              elevation_deg));
  // Bennett 1982, minutes of arc.
  const double refraction_deg = 1.0 / std::tan(from_degrees(elevation_deg + 7.31 / (elevation_deg + 4.4)).value) / 60.0;
  sight.place_m = kSunDistance_m * sun.direction;
  sight.place_sigma_m = kSunDistance_m * 0.05 * from_degrees(std::max(0.0, refraction_deg)).value;
  return sight;
}

void read_horizon(const ConfigTable& table, const ConfigTable& root, SceneSights& sights) {
  const double water_m = table.number("water_altitude_m", {-500, 9000}, 0.0);
  const double height_m = sights.site.altitude_m - water_m;
  if (!(height_m > 0.5))
    table.problem("water_altitude_m",
                  fmt::format("water at least 0.5 m below the camera (at {} m)", sights.site.altitude_m));
  const double sigma_px = table.number("sigma_px", kPixelSigma, root.number("sigma_px", kPixelSigma, 1.0));
  const auto numbers = table.numbers("pixels", 0);
  if (numbers.size() % 2 != 0) table.problem("pixels", "x1, y1, x2, y2, ...: two numbers for each point");
  for (std::size_t i = 0; i + 1 < numbers.size(); i += 2)
    sights.horizon.push_back({{numbers[i], numbers[i + 1]}, dip_of_horizon(height_m, sights.refraction), sigma_px});
}

// Size and lens: the file's own, or the calibration's.
void read_camera_part(const ConfigTable& root, const KnownCalibration& calibrated, SceneSights& sights) {
  const auto scene = calibrated.lens ? root.optional_table("scene") : root.table("scene");
  sights.width = calibrated.width;
  sights.height = calibrated.height;
  if (calibrated.lens) sights.lens = *calibrated.lens;
  if (!scene) return;
  for (const auto& [key, value, other] : {std::tuple{"width", &sights.width, calibrated.width},
                                          std::tuple{"height", &sights.height, calibrated.height}}) {
    *value = scene->integer(key, kSize_px, other > 0 ? std::optional(other) : std::nullopt);
    if (other > 0 && *value != other) scene->problem(key, fmt::format("{}, as the calibration file has it", other));
  }
  if (scene->has("lens") && calibrated.lens) {
    scene->ignore("lens");
    scene->problem("lens", "no lens here, for the calibration file has one");
  } else if (!calibrated.lens) {
    const auto lens = scene->table("lens");
    sights.lens = read_lens_description(lens);
    if (scene->has("lens") && !std::holds_alternative<PinholeParameters>(sights.lens.model))
      lens.problem("model", "\"pinhole\": the scene is drawn through a pinhole");
  }
  if (scene->has("response")) sights.response = scene->choice("response", {"srgb", "linear"});
}

}  // namespace

std::string distance_text(const LandmarkSight& sight) {
  const double distance_m = glm::length(sight.place_m);
  return distance_m < 1e9 ? fmt::format("{:.2f} km", 1e-3 * distance_m) : std::string();
}

Result<KnownCalibration> read_calibrated_scene(const std::filesystem::path& calibration) {
  KnownCalibration calibrated;
  std::error_code error;
  if (!std::filesystem::exists(calibration, error)) return calibrated;
  const auto root = ConfigTable::read_file(calibration);
  if (!root) return fail(root.error());
  if (const auto site = root->optional_table("site")) calibrated.site = read_site(*site);
  if (const auto scene = root->optional_table("scene")) {
    calibrated.width = scene->integer("width", kSize_px);
    calibrated.height = scene->integer("height", kSize_px);
    if (const auto lens = scene->optional_table("lens")) {
      calibrated.lens = read_lens_description(*lens);
      const auto measured = scene->optional_table("measured");
      const auto of_lens = measured ? measured->optional_table("lens") : std::nullopt;
      if (of_lens) {
        const double focal_px = focal_px_of(*calibrated.lens);
        calibrated.focal_sigma = of_lens->number("focal_sigma_px", {0.0, 1e6}, 0.002 * focal_px) / focal_px;
      }
      if (!std::holds_alternative<PinholeParameters>(calibrated.lens->model))
        scene->table("lens").problem("model", "\"pinhole\": the scene is drawn through a pinhole");
    }
    scene->ignore("measured");
  }
  for (const char* key : {"calibration", "site", "sky", "scene"}) root->ignore(key);
  if (auto whole = root->finish(); !whole) return fail(whole.error());
  return calibrated;
}

Result<SceneSights> read_scene_sights(const std::filesystem::path& path, const KnownCalibration& calibrated) {
  const auto root = ConfigTable::read_file(path);
  if (!root) return fail(root.error());
  SceneSights sights;
  if (!calibrated.site || root->has("site"))
    sights.site = read_site(root->table("site"));
  else
    sights.site = *calibrated.site;
  read_camera_part(*root, calibrated, sights);
  sights.refraction = root->number("refraction", {-1.0, 1.0}, kUsualRefraction);
  const auto landmarks = root->tables("landmarks");
  for (const auto& table : landmarks) sights.landmarks.push_back(read_landmark(table, *root, sights));
  const auto sightings = root->tables("sightings");
  for (const auto& table : sightings) sights.landmarks.push_back(read_sighting(table, *root, sights));
  const std::size_t fewest = root->has("horizon") ? 1 : 2;
  if (landmarks.size() + sightings.size() < fewest && !(root->has("landmarks") && landmarks.empty()))
    root->problem("landmarks",
                  "at least 2 tables [[landmarks]] or [[sightings]], and 4 to find a wrong one (1 with a [horizon])");
  root->number("sigma_px", kPixelSigma, 1.0);
  root->number("place_sigma_m", kPlaceSigma_m, 1.0);
  if (const auto horizon = root->optional_table("horizon")) read_horizon(*horizon, *root, sights);
  if (auto whole = root->finish(); !whole) return fail(whole.error());
  return sights;
}

}  // namespace kasumi
