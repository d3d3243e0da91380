#include "estimator/sky/sky_scene.hpp"

#include <algorithm>
#include <cmath>

#include <glm/exponential.hpp>

#include "calib/colour/colorimetry.hpp"
#include "estimator/air/air_path.hpp"
#include "estimator/air/scattering.hpp"
#include "estimator/sky/air_on_the_way.hpp"
#include "estimator/sky/dome.hpp"
#include "estimator/sky/haze_scattering.hpp"
#include "estimator/sky/preetham.hpp"

namespace kasumi {
namespace {

// Altitude of the upper of two domes, between which the air before land is interpolated: above all land drawn.
constexpr double kLandTop_m = 3600.0;

// Hoffman and Preetham's own wavelengths of red, green and blue, and the sun's illuminance outside the air.
constexpr glm::dvec3 kOlderWavelengths_nm{650.0, 570.0, 475.0};
constexpr double kSunOutside_lux = 128e3;  // Hoffman and Preetham's

// zhao: Preetham's haze in the unit his published code uses (physics 3).
sky_text::OlderAir older_air(Turbidity turbidity, const SunDirection& sun, double altitude_m) {
  sky_text::OlderAir air{};
  for (int c = 0; c < 3; ++c) {
    air.rayleigh_per_m[c] = rayleigh_per_m(ScatteringModel::zhao, kOlderWavelengths_nm[c]);
    air.mie_per_m[c] = mie_per_m(ScatteringModel::zhao, kOlderWavelengths_nm[c], turbidity);
  }
  air.asymmetry = 0.76;
  air.altitude_m = altitude_m;
  air.sunlight = kSunOutside_lux / kPi * sky_text::older_transmittance(air, sky_text::older_sky_path_m(sun.z));
  return air;
}

sky_text::PerezSky perez_sky(Turbidity turbidity, const SunDirection& sun) {
  sky_text::PerezSky sky{};
  const PreethamSky model(turbidity, sun);
  sky.zenith = model.luminance_and_chromaticity({0.0, 0.0, 1.0}) * glm::dvec3(1000.0, 1.0, 1.0);
  int c = 0;
  for (const auto quantity : {PerezQuantity::luminance, PerezQuantity::x, PerezQuantity::y}) {
    const auto k = perez_coefficients(quantity, clamp_turbidity(turbidity));
    sky.a[c] = k.a;
    sky.b[c] = k.b;
    sky.c[c] = k.c;
    sky.d[c] = k.d;
    sky.e[c] = k.e;
    sky.zenith[c] /= perez(k, 1.0, zenith_angle(sun));
    ++c;
  }
  return sky;
}

DomeFunction dome_in_srgb(double altitude_m, const DomeRequest& request) {
  return in_space(dome(altitude_m, request.aerosol(), request.sun), xyz_to_linear_srgb());
}

LandLight land_light_at(double altitude_m, const DomeFunction& sky, const DomeRequest& request) {
  DomeScene there;
  there.sky = sky;
  there.sun = request.sun;
  const auto sun = dome_sun(altitude_m, request.aerosol(), request.sun);
  return {glm::max(xyz_to_linear_srgb() * glm::dvec3(sun.illuminance), 0.0),
          glm::max(sky_sums(DomePainter(there)).on_level_ground, 0.0)};
}

constexpr double kPlainAlbedo = 0.2;  // the reference atmosphere's

}  // namespace

double exposure_for(double mean_luminance) {
  // A day's mean sky is shown at .8 of full scale; at dusk the exposure follows by the power .9, so that dusk looks
  // darker than day.
  constexpr double kDay_cd_m2 = 5000.0, kShown = 0.8, kAdaptation = 0.9;
  const double relative = std::max(mean_luminance, 1e-4) / kDay_cd_m2;
  return kShown / (kDay_cd_m2 * std::pow(relative, kAdaptation));
}

HemisphereSums sky_sums(const DomePainter& painter) {
  // Cells of 7.5 deg of azimuth: sums over the sky, in which the aureole is no edge.
  constexpr int kRings = 24, kSectors = 48;
  HemisphereSums sums;
  double log_sum = 0.0;
  for (int ring = 0; ring < kRings; ++ring)
    for (int sector = 0; sector < kSectors; ++sector) {
      const double z = (ring + 0.5) / kRings;  // even in solid angle
      const Direction view = direction_from(Radians{std::acos(z)}, Radians{2.0 * kPi * (sector + 0.5) / kSectors});
      const glm::dvec3 light = painter.sky(view);
      sums.on_level_ground += light * z;
      log_sum += std::log(std::max(sky_text::luminance_of(light), 1e-6));
    }
  sums.on_level_ground *= 2.0 * kPi / (kRings * kSectors);
  sums.mean_luminance = std::exp(log_sum / (kRings * kSectors));
  return sums;
}

DomeScene sky_scene(const DomeRequest& request) {
  DomeScene scene;
  scene.kind = request.kind;
  scene.altitude_m = request.altitude_m;
  scene.sun = request.sun;
  scene.aerial_perspective = request.aerial_perspective;
  scene.sky = dome_in_srgb(request.altitude_m, request);
  scene.lower_m = 0.0;
  scene.higher_m = std::max(request.altitude_m, kLandTop_m);
  scene.lower = dome_in_srgb(scene.lower_m, request);
  scene.higher = dome_in_srgb(scene.higher_m, request);
  scene.air = air_coefficients(request.aerosol());
  scene.land_lower = land_light_at(scene.lower_m, scene.lower, request);
  scene.land_higher = land_light_at(scene.higher_m, scene.higher, request);
  scene.haze = haze_scattering(request.aerosol().kind);
  const auto sky_at = [&](double altitude_m) { return dome_in_srgb(altitude_m, request); };
  const Departures departures = departures_on_the_way(scene, sky_at);
  scene.departures = departures.even;
  scene.departures_sun = departures.sun;
  const glm::dvec3 plain =
      sky_text::land_light(glm::dvec3(kPlainAlbedo), request.sun.z, 1.0, scene.land_lower.sun, scene.land_lower.sky);
  const LightFromBelow below = light_from_below(scene, sky_at, plain);
  scene.below = below.even;
  scene.below_steep = below.steep;
  if (request.sun_disc)
    scene.sun_luminance = glm::max(
        xyz_to_linear_srgb() * glm::dvec3(dome_sun(request.altitude_m, request.aerosol(), request.sun).luminance), 0.0);
  scene.perez = perez_sky(request.turbidity, request.sun);
  scene.older = older_air(request.turbidity, request.sun, request.altitude_m);
  scene.exposure = request.exposure ? *request.exposure : exposure_for(sky_sums(DomePainter(scene)).mean_luminance);
  scene.exposure *= std::exp2(request.exposure_ev);
  return scene;
}

}  // namespace kasumi
