#include "estimator/sky/air_on_the_way.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "base/earth.hpp"

namespace kasumi {
namespace {

using sky_text::AirBetween;

// The inverse of way_between_altitudes.
double altitude_on_the_way(double way, double lower_m, double higher_m) {
  double below = lower_m, above = higher_m;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (below + above);
    (sky_text::way_between_altitudes(middle, lower_m, higher_m) < way ? below : above) = middle;
  }
  return 0.5 * (below + above);
}

// Cosine of the angle to the sun; azimuth from the sun's.
double cos_to_sun(double cos_zenith, double cos_sun_zenith, Radians azimuth) {
  return cos_zenith * cos_sun_zenith + std::sqrt(std::max((1.0 - cos_zenith * cos_zenith) *
                                                              (1.0 - cos_sun_zenith * cos_sun_zenith),
                                                          0.0)) *
                                           std::cos(azimuth.value);
}

// Light from all around at one altitude, without the sun's disc. Azimuths are from the sun's.
struct LightAround {
  struct Patch {
    Direction from;
    double share;  // of the sphere
    glm::dvec3 light;
  };
  std::vector<Patch> patches;

  // Scattered towards an eye that looks this way, by haze that absorbs nothing.
  glm::dvec3 scattered_into(const sky_text::HazeScattering& haze, const Direction& view) const {
    glm::dvec3 light(0.0);
    double all = 0.0;
    for (const Patch& patch : patches) {
      const double cosine = glm::dot(patch.from, view);
      const double weight = patch.share * (haze.height.x * sky_text::dome_lobe(haze.asymmetry.x, cosine) +
                                           haze.height.y * sky_text::dome_lobe(haze.asymmetry.y, cosine));
      light += weight * patch.light;
      all += weight;
    }
    return light / all;
  }
};

LightAround light_around_at(double altitude_m, const AirBetween& air, const sky_text::DomeSky& sky,
                            const glm::dvec3& land, double cos_sun_zenith) {
  constexpr int kRings = 16, kSectors = 20;
  LightAround around;
  for (int ring = 0; ring < kRings; ++ring)
    for (int sector = 0; sector < kSectors; ++sector) {
      const double z = (ring + 0.5) / kRings * 2.0 - 1.0;
      const Radians azimuth{2.0 * kPi * (sector + 0.5) / kSectors};
      const double cos_sun = cos_to_sun(z, cos_sun_zenith, azimuth);
      const double length_m = altitude_m / std::max(-z, 1e-3);
      const glm::dvec3 light = z > 0.0 ? sky_text::dome_sky_light(sky, z, cos_sun)
                                       : sky_text::object_through_air(air, land, altitude_m, 0.0, length_m, cos_sun,
                                                                      cos_sun_zenith);
      around.patches.push_back({direction_from(Radians{std::acos(z)}, azimuth), 1.0 / (kRings * kSectors),
                                glm::max(light, glm::dvec3(0.0))});
    }
  return around;
}

constexpr std::array kAzimuths{from_degrees(30.0), from_degrees(70.0), from_degrees(110.0), from_degrees(150.0)};

}  // namespace

std::array<glm::dvec3, 4> departures_on_the_way(const SkyScene& scene, const SkyAtAltitude& sky_at) {
  const AirBetween air = air_between(scene);
  const double cos_sun_zenith = scene.sun.z;
  std::array<glm::dvec3, 4> departures{};
  for (int place = 0; place < 2; ++place) {
    const double way = sky_text::kDepartureWays[place];
    const double altitude_m = altitude_on_the_way(way, scene.lower_m, scene.higher_m);
    const sky_text::DomeSky sky = text_of(sky_at(altitude_m));
    for (int elevation = 0; elevation < 2; ++elevation) {
      const double up = sky_text::kDepartureSines[elevation];
      const glm::dvec3 lower_lit = sky_text::lit_air(air.air, scene.lower_m, up, cos_sun_zenith);
      const glm::dvec3 higher_lit = sky_text::lit_air(air.air, scene.higher_m, up, cos_sun_zenith);
      glm::dvec3 is(0.0), interpolated(0.0);
      for (const Radians azimuth : kAzimuths) {
        const double cos_sun = cos_to_sun(up, cos_sun_zenith, azimuth);
        is += sky_text::dome_sky_light(sky, up, cos_sun);
        interpolated +=
            sky_text::sky_on_the_way(air.air, sky_text::dome_sky_light(air.lower, up, cos_sun) / lower_lit,
                                     sky_text::dome_sky_light(air.higher, up, cos_sun) / higher_lit, glm::dvec3(0.0),
                                     glm::dvec3(0.0), altitude_m, way, up, cos_sun_zenith);
      }
      departures[static_cast<std::size_t>(2 * place + elevation)] =
          is / glm::max(interpolated, glm::dvec3(1e-9)) - 1.0;
    }
  }
  return departures;
}

LightFromBelow light_from_below(const SkyScene& scene, const SkyAtAltitude& sky_at, const glm::dvec3& land) {
  constexpr std::array kSlopes{0.05, 0.15, 0.3, 0.5};
  const AirBetween air = air_between(scene);
  LightFromBelow result;
  for (std::size_t place = 0; place < 3; ++place) {
    const double way = 0.5 * static_cast<double>(place);
    const double altitude_m = altitude_on_the_way(way, scene.lower_m, scene.higher_m);
    const LightAround around = light_around_at(altitude_m, air, text_of(sky_at(altitude_m)), land, scene.sun.z);
    // Least squares of the difference over share * (even + slope * steep).
    double one = 0.0, slope_once = 0.0, slope_twice = 0.0;
    glm::dvec3 level(0.0), steep(0.0);
    for (const double slope : kSlopes)
      for (const Radians azimuth : kAzimuths) {
        const Direction down = direction_from(Radians{std::acos(-slope)}, azimuth);
        const double seen = sky_text::held_cos_sun(slope, cos_to_sun(-slope, scene.sun.z, azimuth), scene.sun.z);
        const double across = std::sqrt((1.0 - slope * slope) * std::max(1.0 - scene.sun.z * scene.sun.z, 1e-9));
        const Radians turned{std::acos(std::clamp((seen - slope * scene.sun.z) / across, -1.0, 1.0))};
        const Direction mirrored = direction_from(Radians{std::acos(slope)}, turned);
        const glm::dvec3 more = around.scattered_into(scene.haze, down) - around.scattered_into(scene.haze, mirrored);
        const double share = sky_text::onwards_share(slope);
        one += share * share;
        slope_once += share * share * slope;
        slope_twice += share * share * slope * slope;
        level += share * more;
        steep += share * slope * more;
      }
    const double determinant = one * slope_twice - slope_once * slope_once;
    result.even[place] = (slope_twice * level - slope_once * steep) / determinant;
    result.steep[place] = (one * steep - slope_once * level) / determinant;
  }
  return result;
}

}  // namespace kasumi
