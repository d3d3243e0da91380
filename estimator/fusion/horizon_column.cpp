#include "estimator/fusion/horizon_column.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "calib/colour/colorimetry.hpp"
#include "estimator/horizon/low_sky.hpp"

namespace kasumi {
namespace {

// A scene camera's colours and its lens are as a rule not measured.
constexpr InstrumentDoubt kSceneDoubt{true, 0.1, 0.05};
// No model leaves more of a clear low sky unexplained.
constexpr double kMostLeftOver = 0.06;
// A closed sky looks like the thickest haze, 1.3 or more, whose light hardly depends on its amount. Reject amounts
// within a sigma of it.
constexpr double kThickest = 1.2;
constexpr Radians kLowestSun = from_degrees(3.0);

// What a low sky cannot know, of ln(aod) and of the exponent. It is lit air up to 40 km away, which at 10 m/s is the air
// of an hour ago or to come: .2. Aerosol whose height is 800 or 1800 m instead of 1200 makes .1, and .3 of exponent; so
// does a camera mounted .3 deg too high or low.
constexpr double kElsewhere = 0.2, kOtherLayers = 0.1, kMounting = 0.1;
constexpr double kExponentElsewhere = 0.2, kExponentOtherLayers = 0.3, kExponentMounting = 0.2;
constexpr double kLeastSigmaAod = 0.005;

std::vector<SkyReading> readings_in(const LowSky& low, const Camera& scene) {
  const glm::dmat3 to_srgb = xyz_to_linear_srgb() * scene.light_to_xyz();
  std::vector<SkyReading> readings;
  for (const HorizonPatch& patch : low.patches) {
    const SkyReading reading{patch.direction, to_srgb * patch.light, patch.sigma, patch.off_axis};
    if (std::min({reading.light.r, reading.light.g, reading.light.b}) > 0.0) readings.push_back(reading);
  }
  return readings;
}

FoundAerosol with_doubts(FoundAerosol found) {
  const double amount = std::hypot(kElsewhere, kOtherLayers, kMounting);
  const double exponent = std::hypot(kExponentElsewhere, kExponentOtherLayers, kExponentMounting);
  const double aod = std::hypot(amount * found.aerosol.aod_550, kLeastSigmaAod);
  found.covariance.aod_550 += aod * aod;
  found.covariance.angstrom_exponent += exponent * exponent;
  return found;
}

}  // namespace

HorizonColumnFit column_by_horizon(const Camera& scene, const PictureView& picture, const SunDirection& sun,
                                   const ModelToFit& sky) {
  HorizonColumnFit air;
  if (std::asin(sun.z) < kLowestSun.value) {
    air.reason = "the sun is too low";
    return air;
  }
  const LowSky low = read_low_sky(scene, picture);
  const auto readings = readings_in(low, scene);
  air.patches = static_cast<int>(readings.size());
  air.reason = low.reason;
  if (!air.reason.empty()) return air;
  air.fit = fit_sky(readings, sun, sky, kSceneDoubt);
  if (!air.fit.solved) {
    air.reason = "too little low sky";
    return air;
  }
  if (air.fit.log_residual > kMostLeftOver) {
    air.reason = fmt::format("the low sky is like no clear one: {:.0f} % are left over", 100.0 * air.fit.log_residual);
    return air;
  }
  const auto& found = air.fit.found;
  if (found.aerosol.aod_550 + std::sqrt(found.covariance.aod_550) > kThickest) {
    air.reason = "the low sky is that of thick haze, or of a closed sky";
    return air;
  }
  air.reading = ColumnReading{AirObserver::horizon, with_doubts(found)};
  return air;
}

}  // namespace kasumi
