#include "estimator/sky_fit/sky_doubts.hpp"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "base/units.hpp"
#include "estimator/air/scattering.hpp"
#include "estimator/sky/dome.hpp"
#include "estimator/sky/ground_glow.hpp"
#include "estimator/sky/haze_scattering.hpp"

namespace kasumi {
namespace {

constexpr double kSigmaAsymmetry =
    0.05;  // of the aerosol's mean cosine of scattering, which kinds of the same exponent share
// At which molecules scatter back what linear sRGB's channels see of it (against the spectral atmosphere over ground of .6,
// aod .02; at 610 nm red would be 1.4 times too strong).
constexpr glm::dvec3 kGlowChannels_nm{662.0, 561.0, 464.0};
// Of light that aerosol scatters, this much keeps the direction's phase function; the rest is scattered again.
constexpr double kScatteredOnce = 0.8;

double lobe_at(double asymmetry, double cosine) {
  return (1.0 - asymmetry * asymmetry) / std::pow(1.0 + asymmetry * asymmetry - 2.0 * asymmetry * cosine, 1.5);
}
// d ln lobe / d asymmetry
double lobe_slope(double asymmetry, double cosine) {
  return -2.0 * asymmetry / (1.0 - asymmetry * asymmetry) -
         3.0 * (asymmetry - cosine) / (1.0 + asymmetry * asymmetry - 2.0 * asymmetry * cosine);
}

}  // namespace

glm::dvec3 light_on_ground(const RadianceField& sky, const glm::dvec3& sun_illuminance, const SunDirection& sun) {
  constexpr int kRings = 5, kSectors = 6;  // 30 directions: the ground's light is needed to a few per cent
  glm::dvec3 sum = std::max(0.0, sun.z) * sun_illuminance;
  const double azimuth = azimuth_angle(sun).value;
  for (int i = 0; i < kRings; ++i)  // equal steps of cos^2 weigh equally on the ground
    for (int j = 0; j < kSectors; ++j)
      sum +=
          kPi / (kRings * kSectors) *
          sky(direction_from({std::acos(std::sqrt((i + 0.5) / kRings))}, {azimuth + (j + 0.5) * 2.0 * kPi / kSectors}));
  return sum;
}

RadianceDoubts sky_doubts(const Aerosol& aerosol, double altitude_m, const SunDirection& sun,
                          std::span<const Direction> directions, const std::array<Eigen::VectorXd, 3>& log_light,
                          const glm::dvec3& on_ground, double brighter_ground) {
  const GroundGlow brighter(aerosol, altitude_m, kDomeGroundAlbedo + kSigmaGround, on_ground, kGlowChannels_nm);
  const double deviations = std::max(brighter_ground, -1.0);
  const auto haze = haze_scattering(aerosol);
  const double asymmetry = static_cast<double>(haze.asymmetry.x);
  glm::dvec3 molecules, scattering;
  for (int c = 0; c < 3; ++c) {
    const double nm = kDomeChannels_nm[c];
    molecules[c] = molecular_optical_depth(nm) * std::exp(-altitude_m / kRayleighScaleHeight_m);
    scattering[c] =
        optical_depth(aerosol, nm) * std::exp(-altitude_m / kAerosolHeight_m) * static_cast<double>(haze.albedo[c]);
  }
  RadianceDoubts doubts;
  for (auto& channel : doubts) channel.resize(static_cast<Eigen::Index>(directions.size()), kSkyDoubts);
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const glm::dvec3 glow = brighter.radiance(directions[i].z);
    const double cosine = std::clamp(glm::dot(directions[i], sun), -1.0, 1.0), lobe = lobe_at(asymmetry, cosine),
                 slope = kSigmaAsymmetry * lobe_slope(asymmetry, cosine), rayleigh = 0.75 * (1.0 + cosine * cosine);
    for (int c = 0; c < 3; ++c) {
      auto& channel = doubts[static_cast<std::size_t>(c)];
      const double light = std::exp(log_light[static_cast<std::size_t>(c)][row]);
      const double more = glow[c] / std::max(light, glow[c]);
      channel(row, 0) = std::abs(deviations) < 0.01 ? more : std::log1p(std::max(-0.9, more * deviations)) / deviations;
      const double by_aerosol = scattering[c] * lobe, whole = by_aerosol + molecules[c] * rayleigh;
      channel(row, 1) = slope * kScatteredOnce * by_aerosol / std::max(whole, 1e-9);
    }
  }
  return doubts;
}

}  // namespace kasumi
