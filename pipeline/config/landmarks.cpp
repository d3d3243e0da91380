#include "pipeline/config/landmarks.hpp"

#include <cmath>

#include <glm/geometric.hpp>

#include "pipeline/config/placement.hpp"

namespace kasumi {
namespace {

constexpr double kWithinSight_m = 400e3;  // Everest from the plains of Bengal; a farther place is a mistake
constexpr Range kDistances_m{5.0, kWithinSight_m};

std::optional<PictureBox> read_box(const ConfigTable& table, std::string_view key, int width, int height) {
  if (!table.has(key)) return std::nullopt;
  const auto numbers = table.numbers(key, 4, {0.0, 100e3});
  if (numbers.size() != 4) return std::nullopt;
  const PictureBox box{static_cast<int>(numbers[0]), static_cast<int>(numbers[1]), static_cast<int>(numbers[2]),
                       static_cast<int>(numbers[3])};
  if (box.width < 1 || box.height < 1 || box.x + box.width > width || box.y + box.height > height)
    table.problem(key, fmt::format("[x, y, width, height] within the scene camera's {} x {} pixels", width, height));
  return box;
}

}  // namespace

std::vector<Landmark> read_landmarks(const ConfigTable& root, const Site& site) {
  std::vector<Landmark> landmarks;
  for (const auto& table : root.tables("landmarks")) {
    if (table.has("distance_m") && !table.has("latitude_deg")) continue;  // only for visibility
    Landmark landmark;
    landmark.name = table.text("name");
    landmark.place_m =
        east_north_up(site, table.number("latitude_deg", {-90, 90}), table.number("longitude_deg", {-180, 180}),
                      table.number("altitude_m", {-500, 9000}));
    const double distance_m = std::hypot(landmark.place_m.x, landmark.place_m.y);
    const bool whole = table.has("latitude_deg") && table.has("longitude_deg");
    if (whole && distance_m > kWithinSight_m)
      table.problem("latitude_deg", fmt::format("a place within {:.0f} km of the site (it is {:.0f} km away)",
                                                kWithinSight_m / 1e3, distance_m / 1e3));
    landmark.place_m.z += lift_by_refraction(distance_m);
    landmarks.push_back(std::move(landmark));
  }
  return landmarks;
}

std::vector<ContrastLandmark> read_contrast_landmarks(const ConfigTable& root, const std::optional<Site>& site,
                                                      int width, int height) {
  std::vector<ContrastLandmark> landmarks;
  for (const auto& table : root.tables("landmarks")) {
    const bool has_distance = table.has("distance_m");
    const auto surface = read_box(table, "region_px", width, height);
    if (!surface) {
      if (has_distance)
        table.problem("region_px", "[x, y, width, height]: where the picture shows it, since distance_m is given");
      continue;
    }
    ContrastLandmark landmark;
    landmark.name = table.text("name");
    landmark.surface = *surface;
    landmark.against = read_box(table, "against_px", width, height);
    landmark.sky = read_box(table, "sky_px", width, height);
    if (has_distance) {
      landmark.distance_m = table.number("distance_m", kDistances_m);
      landmark.rise_m = table.number("rise_m", {-5000.0, 9000.0}, 0.0);
    } else if (site && table.has("latitude_deg") && table.has("longitude_deg") && table.has("altitude_m")) {
      const double altitude_m = table.number("altitude_m", {-500, 9000});
      landmark.distance_m = glm::length(east_north_up(*site, table.number("latitude_deg", {-90, 90}),
                                                      table.number("longitude_deg", {-180, 180}), altitude_m));
      landmark.rise_m = altitude_m - site->altitude_m;
    } else {
      table.problem("distance_m", site
                                      ? "its distance in metres, or its place (latitude_deg, longitude_deg, altitude_m)"
                                      : "its distance in metres (a place needs a [site])");
    }
    const double usual = landmark.against ? 0.4 : ContrastLandmark{}.contrast;
    const double usual_sigma = landmark.against ? 0.3 : ContrastLandmark{}.contrast_sigma;
    landmark.contrast = table.number("contrast", {-1.0, 1.0}, usual);
    landmark.contrast_sigma = table.number("contrast_sigma", {0.005, 1.0}, usual_sigma);
    landmarks.push_back(std::move(landmark));
  }
  return landmarks;
}

}  // namespace kasumi
