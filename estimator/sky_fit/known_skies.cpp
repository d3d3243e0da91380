#include "estimator/sky_fit/known_skies.hpp"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/exponential.hpp>

#include "calib/colour/colorimetry.hpp"
#include "estimator/sky/site_sky.hpp"

namespace kasumi {

namespace {

KnownRadiance known_sky(const SiteSky& sky, double aod_550, std::span<const SkyReading> readings) {
  KnownRadiance known{aod_550, {}};
  known.log_light.reserve(readings.size());
  for (const SkyReading& reading : readings) {
    const glm::dvec3 xyz = sky.relative_xyz(reading.direction);
    known.log_light.push_back(glm::log(glm::max(xyz_to_linear_srgb() * xyz, glm::dvec3{1e-3 * xyz.y})));
  }
  return known;
}

}  // namespace

std::vector<KnownRadiance> known_skies(std::span<const SkyReading> readings, const SunDirection& sun,
                                       double altitude_m) {
  std::vector<KnownRadiance> skies;
  for (const double turbidity : {2.0, 2.4, 3.0, 4.0, 5.5, 8.0})
    skies.push_back(known_sky(PreethamSky(Turbidity{turbidity}, sun), aerosol_of(turbidity).aod_550, readings));
  for (const AerosolKind kind :
       {AerosolKind::continental, AerosolKind::maritime, AerosolKind::dust, AerosolKind::urban})
    for (const double aod : {0.0, 0.03, 0.06, 0.1, 0.16, 0.25, 0.4, 0.6, 0.9, 1.3}) {
      const AirState air(Aerosol{aod, natural_exponent(kind), kind});
      skies.push_back(known_sky(SiteSky(DaylightModel::dome, air, sun, altitude_m), aod, readings));
    }
  // Fine particles beside coarse ones, as most measured air has them.
  constexpr double kCoarse = 0.35;
  for (const AerosolKind coarse : {AerosolKind::desert, AerosolKind::maritime})
    for (const double aod : {0.03, 0.06, 0.1, 0.16, 0.25, 0.4, 0.6, 0.9}) {
      const AerosolKind fine = AerosolKind::smoke;
      const AirState air(Aerosol{aod, natural_exponent(fine, coarse, kCoarse), fine, coarse, kCoarse});
      skies.push_back(known_sky(SiteSky(DaylightModel::dome, air, sun, altitude_m), aod, readings));
    }
  return skies;
}

std::vector<SkyReading> thinned(std::span<const SkyReading> readings, std::size_t count) {
  const std::size_t kept = std::min(count, readings.size());
  std::vector<SkyReading> some;
  some.reserve(kept);
  for (std::size_t i = 0; i < kept; ++i) some.push_back(readings[i * readings.size() / kept]);
  return some;
}

}  // namespace kasumi
