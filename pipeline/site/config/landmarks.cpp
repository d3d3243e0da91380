#include "pipeline/site/config/landmarks.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "pipeline/site/config/depth_map_landmarks.hpp"
#include "pipeline/site/config/placement.hpp"

namespace kasumi {
namespace {

constexpr double kWithinSight_m = 400e3;  // Everest from the plains of Bengal; a farther place is a mistake
constexpr Range kDistances_m{5.0, kWithinSight_m};

std::optional<LandmarkBox> read_box(const ConfigTable& table, std::string_view key, int width, int height) {
  if (!table.has(key)) return std::nullopt;
  const auto numbers = table.numbers(key, 4, {0.0, 100e3});
  if (numbers.size() != 4) return std::nullopt;
  const LandmarkBox box{static_cast<int>(numbers[0]), static_cast<int>(numbers[1]), static_cast<int>(numbers[2]),
                        static_cast<int>(numbers[3])};
  if (box.width < 1 || box.height < 1 || box.x + box.width > width || box.y + box.height > height)
    table.problem(key, fmt::format("[x, y, width, height] within the scene camera's {} x {} pixels", width, height));
  return box;
}

// ridge_px and strip_px.
std::optional<RidgeStrip> read_ridge(const ConfigTable& table, const LandmarkContext& scene) {
  if (!table.has("ridge_px")) return std::nullopt;
  const auto numbers = table.numbers("ridge_px", 0, {0.0, 100e3});
  const double usual = std::max(3.0, std::round(scene.height / 60.0));
  RidgeStrip ridge{{}, table.number("strip_px", {1.0, 1000.0}, usual)};
  for (std::size_t i = 0; i + 1 < numbers.size(); i += 2) ridge.line.emplace_back(numbers[i], numbers[i + 1]);
  const auto comes_back = [](const glm::dvec2& a, const glm::dvec2& b) { return b.x <= a.x; };
  if (numbers.size() < 4 || numbers.size() % 2 != 0 ||
      std::ranges::adjacent_find(ridge.line, comes_back) != ridge.line.end()) {
    table.problem("ridge_px", "[x, y, x, y, ...]: two or more points of the ridge, from left to right");
    return std::nullopt;
  }
  const auto bounds = ridge.bounds();
  if (bounds.width < 1 || bounds.x + bounds.width > scene.width || bounds.y + bounds.height > scene.height) {
    table.problem("ridge_px",
                  fmt::format("a ridge and {:g} pixels below it (strip_px) within the scene camera's {} x {} pixels",
                              ridge.height_px, scene.width, scene.height));
    return std::nullopt;
  }
  return ridge;
}

// from_depth_map
void add_mapped_landmarks(const ConfigTable& table, const LandmarkContext& scene,
                          std::vector<ContrastLandmark>& landmarks) {
  const int count = table.integer("from_depth_map", {1, 12});
  const auto name = table.text("name", "land");
  if (!scene.distances_m || scene.distances_m->empty()) {
    table.problem("from_depth_map", "a [scene] with a depth_map");
    return;
  }
  if (count < 1) return;
  auto found = landmarks_in(scene, name, count);
  if (found.empty())
    table.problem("from_depth_map", "a depth_map that knows land at one distance somewhere between 300 m and 50 km");
  std::ranges::move(found, std::back_inserter(landmarks));
}

// Where neither distance_m nor a place is given.
void take_mapped_distance(const ConfigTable& table, const LandmarkContext& scene, bool has_site,
                          ContrastLandmark& landmark) {
  const auto mapped = mapped_distance(scene, landmark.surface, landmark.ridge);
  if (!mapped.known)
    return table.problem("distance_m",
                         has_site
                             ? "its distance in metres, or its place (latitude_deg, longitude_deg, altitude_m), or a "
                               "[scene] depth_map that knows it"
                             : "its distance in metres (a place needs a [site]), or a [scene] depth_map that knows it");
  if (!mapped.even())
    return table.problem("distance_m",
                         fmt::format("pixels at one distance: the depth_map says {:.0f} to {:.0f} m there",
                                     mapped.nearest_m, mapped.farthest_m));
  landmark.distance_m = mapped.distance_m;
  landmark.rise_m = rise_of(scene, landmark.surface, mapped.distance_m);
}

}  // namespace

std::vector<Landmark> read_landmarks(const ConfigTable& root, const Site& site) {
  std::vector<Landmark> landmarks;
  for (const auto& table : root.tables("landmarks")) {
    const bool seen = table.has("distance_m") || table.has("region_px") || table.has("ridge_px");
    if ((seen || table.has("from_depth_map")) && !table.has("latitude_deg")) continue;  // only for visibility
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
                                                      const LandmarkContext& scene) {
  std::vector<ContrastLandmark> landmarks;
  for (const auto& table : root.tables("landmarks")) {
    if (table.has("from_depth_map")) {
      add_mapped_landmarks(table, scene, landmarks);
      continue;
    }
    const bool has_distance = table.has("distance_m");
    ContrastLandmark landmark;
    landmark.ridge = read_ridge(table, scene);
    const auto box = read_box(table, "region_px", scene.width, scene.height);
    if (box && landmark.ridge) table.problem("ridge_px", "a region_px or a ridge_px, not both");
    if (!box && !landmark.ridge) {
      if (has_distance && !table.has("ridge_px"))
        table.problem("region_px",
                      "[x, y, width, height]: where the picture shows it, or ridge_px, since distance_m is given");
      continue;
    }
    landmark.surface = landmark.ridge ? landmark.ridge->bounds() : *box;
    landmark.name = table.text("name");
    landmark.against = read_box(table, "against_px", scene.width, scene.height);
    landmark.sky = read_box(table, "sky_px", scene.width, scene.height);
    if (has_distance) {
      landmark.distance_m = table.number("distance_m", kDistances_m);
      landmark.rise_m = table.number("rise_m", {-5000.0, 9000.0}, 0.0);
    } else if (site && table.has("latitude_deg") && table.has("longitude_deg") && table.has("altitude_m")) {
      const double altitude_m = table.number("altitude_m", {-500, 9000});
      landmark.distance_m = glm::length(east_north_up(*site, table.number("latitude_deg", {-90, 90}),
                                                      table.number("longitude_deg", {-180, 180}), altitude_m));
      landmark.rise_m = altitude_m - site->altitude_m;
    } else {
      take_mapped_distance(table, scene, site.has_value(), landmark);
    }
    const double usual = landmark.against ? 0.4 : ContrastLandmark{}.contrast;
    const double usual_sigma = landmark.against ? 0.3 : ContrastLandmark{}.contrast_sigma;
    landmark.contrast = table.number("contrast", {-1.0, 1.0}, usual);
    landmark.contrast_sigma = table.number("contrast_sigma", {0.005, 1.0}, usual_sigma);
    landmark.contrast_stated = table.has("contrast");
    if (table.has("faces_deg")) landmark.faces = from_degrees(table.number("faces_deg", {0.0, 360.0}));
    landmark.infinity_sigma = infinity_sigma(landmark, scene.width);
    landmarks.push_back(std::move(landmark));
  }
  return landmarks;
}

}  // namespace kasumi
