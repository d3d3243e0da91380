// A picture of the sky and of land under it: its view, and how each of its colours is computed. The GPU draws the same
// picture from the same shader sources (gles/air/dome_renderer.hpp).
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "base/geometry.hpp"
#include "base/sky/dome_function.hpp"
#include "base/sky/sky_text.hpp"

namespace kasumi {

enum class PanoramaProjection { perspective, fisheye, equirectangular };
std::string_view name_of(PanoramaProjection projection);
std::optional<PanoramaProjection> panorama_projection_named(std::string_view name);

// The axis points at the picture's middle. fisheye: equidistant, out to 90 deg from the axis.
struct PanoramaView {
  PanoramaProjection projection = PanoramaProjection::perspective;
  int width = 0;
  int height = 0;
  double focal_px = 0.0;  // pixels per radian at the middle
  glm::dmat3 camera_to_world{1.0};
};
Direction direction_of(const PanoramaView& view, const glm::dvec2& pixel);
// The share of a pixel inside a fisheye's image circle; 1 for other projections.
double seen_share(const PanoramaView& view, const glm::dvec2& pixel);
// Where a direction appears in the picture; empty behind a perspective camera.
std::optional<glm::dvec2> pixel_of(const PanoramaView& view, const Direction& direction);

// dome: Kasumi's own model. The others are for comparison.
enum class SkyKind { dome, preetham1999, hoffman_preetham2002, nielsen2003 };
std::string_view name_of(SkyKind kind);  // "preetham1999"
std::optional<SkyKind> sky_kind_named(std::string_view name);

// Light on level and upright land at one altitude; linear sRGB, lux.
struct LandLight {
  glm::dvec3 sun{0.0};  // on a plane facing it
  glm::dvec3 sky{0.0};  // on level ground
};

// Light is linear sRGB, cd/m2.
struct DomeScene {
  SkyKind kind = SkyKind::dome;
  double altitude_m = 0.0;  // of the observer
  Direction sun{0.0, 0.0, 1.0};
  double exposure = 1e-4;         // per cd/m2
  glm::dvec3 sun_luminance{0.0};  // the disc's mean; none is drawn when it is 0
  DomeFunction sky;               // at the observer's altitude; for SkyKind::dome
  DomeFunction lower, higher;     // at the two altitudes that bracket land and observer
  double lower_m = 0.0, higher_m = 1.0;
  AirCoefficients air;
  LandLight land_lower, land_higher;  // at these altitudes
  sky_text::HazeScattering haze{};
  // Of the air between the two altitudes, as base/sky/dome.glsl says.
  std::array<glm::dvec3, 4> departures{}, departures_sun{};
  std::array<glm::dvec3, 3> below{}, below_steep{};
  bool aerial_perspective = true;
  sky_text::PerezSky perez{};  // for preetham1999
  sky_text::OlderAir older{};  // for the others
};

// The shader sources' own structures.
sky_text::DomeSky text_of(const DomeFunction& sky);
sky_text::PathAir text_of(const AirCoefficients& air);
sky_text::AirBetween air_between(const DomeScene& scene);

// The same scene, prepared for evaluating many directions.
class DomePainter {
 public:
  explicit DomePainter(const DomeScene& scene);
  glm::dvec3 sky(const Direction& view) const;  // without the sun's disc
  // pixel_rad: a pixel's width there, for the edge of the disc.
  glm::dvec3 sky_and_sun(const Direction& view, double pixel_rad) const;
  glm::dvec3 shown_sky_and_sun(const Direction& view, double pixel_rad) const;  // encoded sRGB, 0 .. 1
  // Diffuse land at a place (metres; x east, y north, z up from sea level below the observer) as the observer sees it.
  glm::dvec3 land(const glm::dvec3& place, double land_altitude_m, const glm::dvec3& normal,
                  const glm::dvec3& albedo) const;
  // An object of known radiance seen through the air.
  glm::dvec3 through_air(const glm::dvec3& light, const glm::dvec3& place, double object_altitude_m) const;
  // Encoded sRGB, 0 .. 1, without and with what the lens scatters of the sun towards `view`.
  glm::dvec3 shown(const glm::dvec3& light) const;
  glm::dvec3 shown(const glm::dvec3& light, const Direction& view) const;

 private:
  struct Disc {
    glm::dvec3 light{0.0};
    double coverage = 0.0;
  };
  Disc disc(const Direction& view, double pixel_rad) const;

  DomeScene scene_;
  sky_text::DomeSky sky_;
  sky_text::AirBetween between_;
};

}  // namespace kasumi
