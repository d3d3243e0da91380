#include "estimator/sky/air_on_the_way.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

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
  return cos_zenith * cos_sun_zenith +
         std::sqrt(std::max((1.0 - cos_zenith * cos_zenith) * (1.0 - cos_sun_zenith * cos_sun_zenith), 0.0)) *
             std::cos(azimuth.value);
}

// Least squares of colours over two terms.
class TwoTerms {
 public:
  void add(const glm::dvec2& terms, const glm::dvec3& colour, double weight) {
    square_ += weight * glm::outerProduct(terms, terms);
    sums_ += weight * glm::outerProduct(terms, colour);
  }
  glm::dmat2x3 found() const {
    const double ridge = 1e-4 * (square_[0][0] + square_[1][1]);  // under a sun in the zenith terms are proportional
    return glm::transpose(glm::inverse(square_ + glm::dmat2(ridge)) * sums_);
  }

 private:
  glm::dmat2 square_{0.0};
  glm::dmat3x2 sums_{0.0};
};

// Light from all around at one altitude, without the sun's disc. Azimuths are from the sun's.
struct SurroundingPatches {
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

SurroundingPatches light_around_at(double altitude_m, const AirBetween& air, const sky_text::DomeSky& sky,
                                   const glm::dvec3& land, double cos_sun_zenith) {
  // Even solid angles, 11 deg wide: the dome is smooth but for the aureole.
  constexpr int kRings = 16, kSectors = 20;
  SurroundingPatches around;
  for (int ring = 0; ring < kRings; ++ring)
    for (int sector = 0; sector < kSectors; ++sector) {
      const double z = (ring + 0.5) / kRings * 2.0 - 1.0;
      const Radians azimuth{2.0 * kPi * (sector + 0.5) / kSectors};
      const double cos_sun = cos_to_sun(z, cos_sun_zenith, azimuth);
      const double length_m = altitude_m / std::max(-z, 1e-3);
      const glm::dvec3 light =
          z > 0.0 ? sky_text::dome_sky_light(sky, z, cos_sun)
                  : sky_text::object_through_air(air, land, altitude_m, 0.0, length_m, cos_sun, cos_sun_zenith);
      around.patches.push_back({direction_from(Radians{std::acos(z)}, azimuth), 1.0 / (kRings * kSectors),
                                glm::max(light, glm::dvec3(0.0))});
    }
  return around;
}

// From the sun's.
constexpr std::array kAzimuths{from_degrees(15.0),  from_degrees(45.0),  from_degrees(75.0),
                               from_degrees(105.0), from_degrees(135.0), from_degrees(165.0)};

// The direction above the horizon whose sky object_through_air takes for one as far below it: at the mirrored zenith
// angle, and as near as can be at the same angle to the sun.
Direction mirrored(double slope, Radians azimuth, double cos_sun_zenith) {
  const double cos_sun = sky_text::held_cos_sun(slope, cos_to_sun(-slope, cos_sun_zenith, azimuth), cos_sun_zenith);
  const double across = std::sqrt((1.0 - slope * slope) * std::max(1.0 - cos_sun_zenith * cos_sun_zenith, 1e-9));
  const double cos_azimuth = std::clamp((cos_sun - slope * cos_sun_zenith) / across, -1.0, 1.0);
  return direction_from(Radians{std::acos(slope)}, Radians{std::acos(cos_azimuth)});
}

}  // namespace

Departures departures_on_the_way(const DomeScene& scene, const DomeAtAltitude& sky_at) {
  const AirBetween air = air_between(scene);
  const double cos_sun_zenith = scene.sun.z;
  Departures departures;
  for (int place = 0; place < 2; ++place) {
    const double way = sky_text::kDepartureWays[place];
    const double altitude_m = altitude_on_the_way(way, scene.lower_m, scene.higher_m);
    const sky_text::DomeSky sky = text_of(sky_at(altitude_m));
    for (int elevation = 0; elevation < 2; ++elevation) {
      const double up = sky_text::kDepartureSines[elevation];
      const glm::dvec3 lower_lit = sky_text::lit_air(air.air, scene.lower_m, up, cos_sun_zenith);
      const glm::dvec3 higher_lit = sky_text::lit_air(air.air, scene.higher_m, up, cos_sun_zenith);
      TwoTerms terms;
      for (const Radians azimuth : kAzimuths) {
        const double cos_sun = cos_to_sun(up, cos_sun_zenith, azimuth);
        const glm::dvec3 none(0.0);
        const glm::dvec3 interpolated =
            sky_text::sky_on_the_way(air.air, sky_text::dome_sky_light(air.lower, up, cos_sun) / lower_lit,
                                     sky_text::dome_sky_light(air.higher, up, cos_sun) / higher_lit, none, none,
                                     altitude_m, way, up, cos_sun_zenith);
        terms.add(glm::dvec2(1.0, sky_text::dome_lobe(sky_text::kAroundSun, cos_sun)),
                  sky_text::dome_sky_light(sky, up, cos_sun) / glm::max(interpolated, glm::dvec3(1e-9)) - 1.0, 1.0);
      }
      const auto index = static_cast<std::size_t>(2 * place + elevation);
      const glm::dmat2x3 found = terms.found();
      departures.even[index] = found[0];
      departures.sun[index] = found[1];
    }
  }
  return departures;
}

LightFromBelow light_from_below(const DomeScene& scene, const DomeAtAltitude& sky_at, const glm::dvec3& land) {
  constexpr std::array kSlopes{0.05, 0.15, 0.3, 0.5};  // the steepnesses that are tried; least squares choose
  constexpr int kPasses = 2;                           // the light from below itself passes this air
  AirBetween air = air_between(scene);
  for (int pass = 0; pass < kPasses; ++pass)
    for (int place = 0; place < 3; ++place) {
      const double altitude_m = altitude_on_the_way(0.5 * place, scene.lower_m, scene.higher_m);
      const SurroundingPatches around =
          light_around_at(altitude_m, air, text_of(sky_at(altitude_m)), land, scene.sun.z);
      TwoTerms terms;  // of onwards_share * (below + slope * below_steep), for least squares of relative light
      for (const double slope : kSlopes)
        for (const Radians azimuth : kAzimuths) {
          const glm::dvec3 light = around.scattered_into(scene.haze, mirrored(slope, azimuth, scene.sun.z));
          const glm::dvec3 more =
              around.scattered_into(scene.haze, direction_from(Radians{std::acos(-slope)}, azimuth)) - light;
          terms.add(sky_text::onwards_share(slope) * glm::dvec2(1.0, slope), more,
                    1.0 / std::pow(std::max(sky_text::luminance_of(light), 1e-3), 2));
        }
      const glm::dmat2x3 found = terms.found();
      for (int from = place; from < (pass == 0 ? 3 : place + 1); ++from) {  // the best guess for what is higher
        air.below[from] = found[0];
        air.below_steep[from] = found[1];
      }
    }
  LightFromBelow result;
  std::copy(std::begin(air.below), std::end(air.below), result.even.begin());
  std::copy(std::begin(air.below_steep), std::end(air.below_steep), result.steep.begin());
  return result;
}

}  // namespace kasumi
