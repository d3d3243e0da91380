#include "pipeline/lab/sky/sky_reference.hpp"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace kasumi {
namespace {

LandHit between(const LandVertex& a, const LandVertex& b, double part) {
  const auto mixed = [part](const auto& x, const auto& y) { return glm::mix(glm::dvec3(x), glm::dvec3(y), part); };
  return {mixed(a.position, b.position), std::lerp(double{a.altitude_m}, double{b.altitude_m}, part),
          mixed(a.normal, b.normal), mixed(a.albedo, b.albedo)};
}
LandHit between(const LandHit& a, const LandHit& b, double part) {
  return {glm::mix(a.place, b.place, part), std::lerp(a.altitude_m, b.altitude_m, part),
          glm::mix(a.normal, b.normal, part), glm::mix(a.albedo, b.albedo, part)};
}

double pixel_rad(const PanoramaView& view) {
  return 1.0 / view.focal_px;
}

}  // namespace

std::optional<LandHit> LandRayCaster::along(const Direction& view, double observer_m) const {
  const double across = std::max(std::hypot(view.x, view.y), 1e-9), slope = view.z / across;
  double turned = std::fmod(azimuth_angle(view).value - from_.value, 2.0 * kPi);
  if (turned < 0.0) turned += 2.0 * kPi;
  const double column = turned / (to_.value - from_.value) * (land_.columns - 1);
  if (column > land_.columns - 1) return std::nullopt;
  const int left = std::min(static_cast<int>(column), land_.columns - 2);
  const auto point = [&](int ring) { return between(land_.at(left, ring), land_.at(left + 1, ring), column - left); };
  // Height of the land above the line of sight.
  const auto over = [&](const LandHit& hit) {
    return hit.place.z - observer_m - slope * std::hypot(hit.place.x, hit.place.y);
  };
  LandHit before = point(0);
  double before_over = over(before);
  if (before_over >= 0.0) return before;
  for (int ring = 1; ring < land_.rings; ++ring) {
    const LandHit here = point(ring);
    const double here_over = over(here);
    if (here_over >= 0.0) return between(before, here, before_over / (before_over - here_over));
    before = here;
    before_over = here_over;
  }
  return std::nullopt;
}

glm::dvec3 sky_shown_at(const PanoramaView& view, const DomePainter& painter, double observer_m,
                        const LandRayCaster* land, const glm::dvec2& pixel) {
  const Direction direction = direction_of(view, pixel);
  if (land)
    if (const auto hit = land->along(direction, observer_m))
      return painter.shown(painter.land(hit->place, hit->altitude_m, hit->normal, hit->albedo), direction);
  return painter.shown_sky_and_sun(direction, pixel_rad(view));
}

glm::dvec3 sky_light_at(const PanoramaView& view, const DomePainter& painter, double observer_m,
                        const LandRayCaster* land, const glm::dvec2& pixel) {
  const Direction direction = direction_of(view, pixel);
  const auto hit = land ? land->along(direction, observer_m) : std::nullopt;
  return hit ? painter.land(hit->place, hit->altitude_m, hit->normal, hit->albedo) : painter.sky(direction);
}

Image<glm::vec3> sky_light_picture(const PanoramaView& view, const DomeScene& scene, const LandRayCaster* land) {
  const DomePainter painter(scene);
  Image<glm::vec3> picture(view.width, view.height);
  for (int y = 0; y < view.height; ++y)
    for (int x = 0; x < view.width; ++x) {
      const glm::dvec2 pixel(x, y);
      if (seen_share(view, pixel) <= 0.0) continue;
      const Direction direction = direction_of(view, pixel);
      const auto hit = land ? land->along(direction, scene.altitude_m) : std::nullopt;
      picture.at(x, y) = glm::vec3(hit ? painter.land(hit->place, hit->altitude_m, hit->normal, hit->albedo)
                                       : painter.sky_and_sun(direction, pixel_rad(view)));
    }
  return picture;
}

Image<Rgb8> sky_shown_picture(const PanoramaView& view, const DomeScene& scene, const LandRayCaster* land) {
  const DomePainter painter(scene);
  Image<Rgb8> picture(view.width, view.height);
  for (int y = 0; y < view.height; ++y)
    for (int x = 0; x < view.width; ++x) {
      const glm::dvec2 pixel(x, y);
      const double share = seen_share(view, pixel);
      if (share <= 0.0) continue;
      picture.at(x, y) = Rgb8(
          glm::round(255.0 * share * glm::clamp(sky_shown_at(view, painter, scene.altitude_m, land, pixel), 0.0, 1.0)));
    }
  return picture;
}

}  // namespace kasumi
