#include "base/sky/dome_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "base/sky/sun_disc.hpp"

namespace kasumi {
namespace {

template <class Kind, std::size_t N>
std::optional<Kind> named(const std::array<Kind, N>& all, std::string_view name) {
  for (const Kind kind : all)
    if (name_of(kind) == name) return kind;
  return std::nullopt;
}

}  // namespace

std::string_view name_of(PanoramaProjection projection) {
  switch (projection) {
    case PanoramaProjection::perspective: return "perspective";
    case PanoramaProjection::fisheye: return "fisheye";
    case PanoramaProjection::equirectangular: return "equirectangular";
  }
  return "?";
}

std::optional<PanoramaProjection> panorama_projection_named(std::string_view name) {
  using enum PanoramaProjection;
  return named(std::array{perspective, fisheye, equirectangular}, name);
}

std::string_view name_of(SkyKind kind) {
  switch (kind) {
    case SkyKind::dome: return "dome";
    case SkyKind::preetham1999: return "preetham1999";
    case SkyKind::hoffman_preetham2002: return "hoffman-preetham2002";
    case SkyKind::nielsen2003: return "nielsen2003";
  }
  return "?";
}

std::optional<SkyKind> sky_kind_named(std::string_view name) {
  using enum SkyKind;
  return named(std::array{dome, preetham1999, hoffman_preetham2002, nielsen2003}, name);
}

Direction direction_of(const PanoramaView& view, const glm::dvec2& pixel) {
  const glm::dvec2 place = pixel + 0.5 - 0.5 * glm::dvec2(view.width, view.height);
  switch (view.projection) {
    case PanoramaProjection::perspective: return view.camera_to_world * sky_text::perspective_ray(place, view.focal_px);
    case PanoramaProjection::fisheye: return view.camera_to_world * sky_text::fisheye_ray(place, view.focal_px);
    case PanoramaProjection::equirectangular:
      return view.camera_to_world * sky_text::equirectangular_ray(place, view.focal_px);
  }
  return {0.0, 0.0, 1.0};
}

double seen_share(const PanoramaView& view, const glm::dvec2& pixel) {
  if (view.projection != PanoramaProjection::fisheye) return 1.0;
  const glm::dvec2 place = pixel + 0.5 - 0.5 * glm::dvec2(view.width, view.height);
  return std::clamp(0.5 * kPi * view.focal_px + 0.5 - glm::length(place), 0.0, 1.0);
}

std::optional<glm::dvec2> pixel_of(const PanoramaView& view, const Direction& direction) {
  const glm::dvec3 ray = glm::transpose(view.camera_to_world) * direction;
  glm::dvec2 place{0.0};
  switch (view.projection) {
    case PanoramaProjection::perspective: {
      const glm::dvec3 deep = sky_text::perspective_place(ray, view.focal_px);
      if (deep.z <= 1e-9) return std::nullopt;
      place = glm::dvec2(deep) / deep.z;
      break;
    }
    case PanoramaProjection::fisheye: place = sky_text::fisheye_place(ray, view.focal_px); break;
    case PanoramaProjection::equirectangular: place = sky_text::equirectangular_place(ray, view.focal_px); break;
  }
  return place + 0.5 * glm::dvec2(view.width, view.height) - 0.5;
}

sky_text::DomeSky text_of(const DomeFunction& sky) {
  sky_text::DomeSky text{sky.horizon_sine, sky.steepness, glm::dvec3(sky.lobes), {}};
  for (std::size_t i = 0; i < sky.coefficients.size(); ++i) text.coefficients[i] = glm::dvec3(sky.coefficients[i]);
  return text;
}

sky_text::PathAir text_of(const AirCoefficients& air) {
  sky_text::PathAir text{};
  for (std::size_t n = 0; n < kAirNodes; ++n) {
    text.weight[n] = glm::dvec3(air.weight[n]);
    text.molecules_per_m[n] = glm::dvec3(air.molecules_per_m[n]);
    text.aerosol_per_m[n] = glm::dvec3(air.aerosol_per_m[n]);
    text.ozone[n] = glm::dvec3(air.ozone[n]);
  }
  return text;
}

sky_text::AirBetween air_between(const DomeScene& scene) {
  sky_text::AirBetween air{};
  air.lower = text_of(scene.lower);
  air.higher = text_of(scene.higher);
  air.altitude_m = {scene.lower_m, scene.higher_m};
  air.air = text_of(scene.air);
  air.haze = scene.haze;
  air.sun_lower = scene.land_lower.sun;
  air.sun_higher = scene.land_higher.sun;
  std::copy(scene.departures.begin(), scene.departures.end(), air.departures);
  std::copy(scene.departures_sun.begin(), scene.departures_sun.end(), air.departures_sun);
  std::copy(scene.below.begin(), scene.below.end(), air.below);
  std::copy(scene.below_steep.begin(), scene.below_steep.end(), air.below_steep);
  return air;
}

DomePainter::DomePainter(const DomeScene& scene)
    : scene_(scene), sky_(text_of(scene.sky)), between_(air_between(scene)) {}

glm::dvec3 DomePainter::sky(const Direction& view) const {
  const double cos_sun = glm::dot(view, scene_.sun);
  switch (scene_.kind) {
    case SkyKind::dome: return glm::dvec3(sky_text::dome_sky_light(sky_, view.z, cos_sun));
    case SkyKind::preetham1999: return sky_text::preetham_sky(scene_.perez, view.z, cos_sun);
    case SkyKind::hoffman_preetham2002: return sky_text::hoffman_preetham_sky(scene_.older, view.z, cos_sun);
    case SkyKind::nielsen2003: return sky_text::nielsen_sky(scene_.older, view.z, cos_sun);
  }
  return glm::dvec3(0.0);
}

DomePainter::Disc DomePainter::disc(const Direction& view, double pixel_rad) const {
  if (scene_.sun_luminance == glm::dvec3(0.0)) return {};
  const double radius{kDomeSunRadius_rad};
  const double off = angle_between(view, scene_.sun).value / radius;
  return {sky_text::sun_disc_light(scene_.sun_luminance, off), sky_text::sun_coverage(off, 0.5 * pixel_rad / radius)};
}

glm::dvec3 DomePainter::sky_and_sun(const Direction& view, double pixel_rad) const {
  const Disc sun = disc(view, pixel_rad);
  return sky(view) + sun.coverage * sun.light;
}

glm::dvec3 DomePainter::shown_sky_and_sun(const Direction& view, double pixel_rad) const {
  const Disc sun = disc(view, pixel_rad);
  const glm::dvec3 behind = sky(view);
  if (sun.coverage <= 0.0) return shown(behind, view);
  return glm::mix(shown(behind, view), shown(behind + sun.light, view), sun.coverage);
}

glm::dvec3 DomePainter::land(const glm::dvec3& place, double land_altitude_m, const glm::dvec3& normal,
                             const glm::dvec3& albedo) const {
  const double way = sky_text::way_between_altitudes(land_altitude_m, scene_.lower_m, scene_.higher_m);
  const glm::dvec3 light = sky_text::land_light(albedo, glm::dot(normal, scene_.sun), normal.z,
                                                glm::mix(scene_.land_lower.sun, scene_.land_higher.sun, way),
                                                glm::mix(scene_.land_lower.sky, scene_.land_higher.sky, way));
  return through_air(light, place, land_altitude_m);
}

glm::dvec3 DomePainter::through_air(const glm::dvec3& light, const glm::dvec3& place, double object_altitude_m) const {
  if (!scene_.aerial_perspective) return light;
  const glm::dvec3 from_observer = place - glm::dvec3(0.0, 0.0, scene_.altitude_m);
  const double length_m = glm::length(from_observer);
  const double cos_sun = glm::dot(from_observer, scene_.sun) / std::max(length_m, 1.0);
  switch (scene_.kind) {
    case SkyKind::hoffman_preetham2002:
      return sky_text::hoffman_preetham_object(scene_.older, light, length_m, cos_sun);
    case SkyKind::nielsen2003:
      return sky_text::nielsen_object(scene_.older, light, object_altitude_m, length_m, cos_sun);
    default:
      return sky_text::object_through_air(between_, light, scene_.altitude_m, object_altitude_m, length_m, cos_sun,
                                          scene_.sun.z);
  }
}

glm::dvec3 DomePainter::shown(const glm::dvec3& light) const {
  return sky_text::srgb_encoded(sky_text::tone_mapped(light, scene_.exposure));
}

glm::dvec3 DomePainter::shown(const glm::dvec3& light, const Direction& view) const {
  return shown(light + sky_text::sun_glare(scene_.sun_luminance, glm::length(view - scene_.sun)));
}

}  // namespace kasumi
