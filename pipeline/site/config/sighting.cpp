#include "pipeline/site/config/sighting.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "base/earth.hpp"

namespace kasumi {

namespace {

using Verdict = Sighting::Verdict;

std::array<glm::dvec3, 8> corners_of(const Installation& installation, const ModelBounds& bounds) {
  const auto to_world = model_to_world(installation.object.placement);
  std::array<glm::dvec3, 8> corners;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const glm::dvec3 corner{i & 1 ? bounds.highest.x : bounds.lowest.x, i & 2 ? bounds.highest.y : bounds.lowest.y,
                            i & 4 ? bounds.highest.z : bounds.lowest.z};
    corners[i] = glm::dvec3(to_world * glm::dvec4(corner, 1.0));
  }
  return corners;
}

// Height above the sea below which the earth's curvature hides a place, metres.
double hidden_by_the_sea_m(double altitude_m, double distance_m) {
  const double seen_radius = kEarthRadius_m / (1.0 - kUsualRefraction);
  const double to_horizon = std::sqrt(2.0 * seen_radius * std::max(altitude_m, 0.0));
  const double beyond = std::max(0.0, distance_m - to_horizon);
  return beyond * beyond / (2.0 * seen_radius);
}

// What is out of all proportion was probably meant in another unit.
std::string doubt_of_units(const std::array<glm::dvec3, 8>& corners, double distance_m) {
  constexpr double kFarthestSeen_m = 300e3, kUsualFrom_m = 100.0, kUsualTo_m = 100e3;
  const double size_m = glm::length(corners[7] - corners[0]);
  const auto usual = [&](double metres) { return metres >= kUsualFrom_m && metres <= kUsualTo_m; };
  if (distance_m > kFarthestSeen_m && usual(distance_m / 1000.0))
    return fmt::format(
        " (a thousand times {:.2f} km: is its place in metres, and are latitude and longitude in order?)",
        distance_m / 1e6);
  if (distance_m > kFarthestSeen_m) return " (farther than anything is seen: are latitude and longitude in order?)";
  if (distance_m < size_m && distance_m < kUsualFrom_m && usual(distance_m * 1000.0))
    return fmt::format(" (the camera stands in it: was {:.2f} km meant, and kilometres given for metres?)", distance_m);
  if (size_m > 0.0 && size_m < 1e-3 * distance_m && size_m < 1.0)
    return fmt::format(" (it is {:.3g} m large: is the model in metres?)", size_m);
  return {};
}

// Extent of the corners in pixels.
struct Span {
  glm::dvec2 least{1e18}, greatest{-1e18};
};

std::string offset_text(const Camera& scene, const glm::dvec3& centre_m) {
  const glm::dvec3 in_camera = glm::transpose(scene.to_world) * centre_m, middle{0, 0, 1};
  const double right_deg = to_degrees({std::atan2(in_camera.x, in_camera.z)});
  const double up_deg = to_degrees({std::atan2(-in_camera.y, std::hypot(in_camera.x, in_camera.z))});
  return fmt::format("{:.1f} deg {} and {:.1f} deg {} the middle of the picture", std::abs(right_deg),
                     right_deg < 0 ? "left" : "right", std::abs(up_deg), up_deg < 0 ? "below" : "above");
}

// Whether things in front hide it: masked pixels, or a depth nearer than its nearest corner.
bool is_covered(const Installation& installation, const Span& span, double nearest_m) {
  const auto& mask = installation.scene.mask;
  const auto& distances_m = installation.scene_distances_m;
  if (mask.empty() && distances_m.empty()) return false;
  const auto is_open = [&](int x, int y) {
    const bool masked = !mask.empty() && mask.at(x, y) == 0;
    const double real_m = distances_m.empty() ? 0.0 : double(distances_m.at(x, y));
    return !masked && !(real_m > 0.0 && real_m < nearest_m);
  };
  const int width = installation.scene.width, height = installation.scene.height;
  const auto within = [](double v, int count) { return static_cast<int>(std::clamp(std::lround(v), 0L, count - 1L)); };
  for (int y = within(span.least.y, height); y <= within(span.greatest.y, height); ++y)
    for (int x = within(span.least.x, width); x <= within(span.greatest.x, width); ++x)
      if (is_open(x, y)) return false;
  return true;
}

}  // namespace

Sighting sight_object(const Installation& installation, const ModelBounds& bounds, std::string_view what) {
  const Camera& scene = installation.scene;
  const auto corners = corners_of(installation, bounds);
  glm::dvec3 centre{0.0};
  double highest_m = -1e18, nearest_m = 1e18;
  Span span;
  int before = 0, projected = 0;
  for (const auto& corner : corners) {
    centre += corner / 8.0;
    highest_m = std::max(highest_m, corner.z);
    nearest_m = std::min(nearest_m, glm::length(corner));
    if ((glm::transpose(scene.to_world) * corner).z > 0.0) ++before;
    const auto pixel = glm::length(corner) > 0.0 ? scene.pixel_of(glm::normalize(corner)) : std::nullopt;
    if (!pixel) continue;
    ++projected;
    span.least = glm::min(span.least, *pixel);
    span.greatest = glm::max(span.greatest, *pixel);
  }

  Sighting sighting;
  sighting.distance_m = glm::length(centre);
  const double distance = std::hypot(centre.x, centre.y);
  const auto place = fmt::format("{:.2f} km away at azimuth {:.1f} deg{}", sighting.distance_m / 1000.0,
                                 to_degrees(azimuth_angle(centre)), doubt_of_units(corners, sighting.distance_m));
  const auto result = [&](Verdict verdict, std::string message) {
    sighting.verdict = verdict;
    sighting.message = std::move(message);
    return sighting;
  };
  if (before == 0)
    return result(Verdict::behind, fmt::format("{} is behind the scene camera: {}; the camera looks to {:.1f} "
                                               "deg (object's place, or scene.heading_deg)",
                                               what, place, to_degrees(azimuth_angle(scene.to_world[2]))));
  const double right = scene.width - 0.5, bottom = scene.height - 0.5;
  const bool beside_picture = projected == 0 || span.greatest.x < -0.5 || span.greatest.y < -0.5 ||
                              span.least.x > right || span.least.y > bottom;
  if (beside_picture)
    return result(Verdict::outside,
                  fmt::format("{} is outside the picture: {}, {}", what, place, offset_text(scene, centre)));

  // At the place, the tangent plane lies d^2 / 2R above the earth, so the sea is that much farther below.
  const double above_sea_m = installation.site.altitude_m + highest_m + distance * distance / (2.0 * kEarthRadius_m);
  const double hidden_m = hidden_by_the_sea_m(installation.site.altitude_m, distance);
  if (above_sea_m < hidden_m)
    return result(Verdict::below_horizon, fmt::format("{} is below the horizon: {}, its top is {:.0f} m above the "
                                                      "sea, and everything below {:.0f} m is hidden there",
                                                      what, place, above_sea_m, hidden_m));
  if (is_covered(installation, span, nearest_m))
    return result(Verdict::behind_the_mask,
                  fmt::format("{} is hidden: {}, completely behind what scene.mask{} covers", what, place,
                              installation.scene_distances_m.empty() ? "" : " or scene.depth_map"));

  sighting.least_px = span.least;
  sighting.greatest_px = span.greatest;
  const glm::dvec2 size = span.greatest - span.least;
  const bool cut = projected < 8 || span.least.x < -0.5 || span.least.y < -0.5 || span.greatest.x > right ||
                   span.greatest.y > bottom;
  return result(cut ? Verdict::cut_off : Verdict::visible,
                fmt::format("{} is in the picture{}: {}, {:.0f} x {:.0f} pixels at ({:.0f}, {:.0f})", what,
                            cut ? ", cut by its edge" : "", place, size.x, size.y,
                            0.5 * (span.least.x + span.greatest.x), 0.5 * (span.least.y + span.greatest.y)));
}

}  // namespace kasumi
