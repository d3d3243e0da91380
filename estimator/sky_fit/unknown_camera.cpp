#include "estimator/sky_fit/unknown_camera.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "base/square.hpp"
#include "estimator/sky_fit/known_skies.hpp"

namespace kasumi {
namespace {

constexpr std::size_t kLookedAt = 160;   // as in tone_curve.cpp: bounds the time
constexpr int kToneSteps = 61;           // a tenth of a standard deviation each
constexpr double kReach = 3.0;           // standard deviations of the prior, on either side
constexpr double kKnownApart = 0.03;     // of ln light: the known skies are about that far apart
constexpr double kValuesOfOneSky = 8.0;  // of one sky seen through one lens

// Sums over readings and colours, each colour without its mean: of ln light as read (y), as a sky has it (x), and of the
// square of the distance from the optical axis (r).
struct Sums {
  double yy = 0.0, yx = 0.0, xx = 0.0, yr = 0.0, xr = 0.0, rr = 0.0;
  // Mean square that y = exponent x - loss r leaves, the loss being the likeliest by its prior.
  double mean_square(double exponent, double stiffness) const {
    const double left = yy - 2.0 * exponent * yx + exponent * exponent * xx, along = yr - exponent * xr;
    return std::max(0.0, left - along * along / (rr + stiffness));
  }
  // That loss, of light before the tone curve.
  double rim_loss(double exponent, double stiffness) const {
    return -(yr - exponent * xr) / (rr + stiffness) / exponent;
  }
};

Sums sums_of(std::span<const SkyReading> readings, const KnownRadiance& sky) {
  const auto n = static_cast<double>(readings.size());
  glm::dvec3 y{0.0}, x{0.0};
  double r = 0.0;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    y += glm::log(readings[i].light) / n;
    x += sky.log_light[i] / n;
    r += square(readings[i].off_axis) / n;
  }
  Sums sums;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const glm::dvec3 dy = glm::log(readings[i].light) - y, dx = sky.log_light[i] - x;
    const glm::dvec3 dr{square(readings[i].off_axis) - r};
    const double share = 1.0 / (3.0 * n);
    sums.yy += share * glm::dot(dy, dy);
    sums.yx += share * glm::dot(dy, dx);
    sums.xx += share * glm::dot(dx, dx);
    sums.yr += share * glm::dot(dy, dr);
    sums.xr += share * glm::dot(dx, dr);
    sums.rr += share * glm::dot(dr, dr);
  }
  return sums;
}

struct Moments {
  double mean = 0.0, sigma = 0.0;
};

struct Instrument {
  Moments log_exponent, rim_loss;
};

Instrument instrument_of(std::span<const SkyReading> all, const SunDirection& sun, double altitude_m,
                         const CameraBelief& belief) {
  const std::vector<SkyReading> readings = thinned(all, kLookedAt);
  std::vector<Sums> skies;
  for (const KnownRadiance& sky : known_skies(readings, sun, altitude_m)) skies.push_back(sums_of(readings, sky));
  const double stiffness = square(kKnownApart / belief.rim_loss);
  struct Step {
    double log_exponent = 0.0, likelihood = 0.0, rim_loss = 0.0, rim_square = 0.0;  // of the rim: times likelihood
  };
  std::vector<Step> steps;
  double most = 0.0;
  for (int i = 0; i < kToneSteps; ++i) {
    const double off = kReach * (2.0 * i / (kToneSteps - 1) - 1.0);
    Step step{belief.log_exponent + off * belief.sigma_log_exponent, 0.0, 0.0, 0.0};
    const double exponent = std::exp(step.log_exponent);
    for (const Sums& sums : skies) {
      const double left = sums.mean_square(exponent, stiffness) + square(kKnownApart);
      const double loss = sums.rim_loss(exponent, stiffness);
      const double variance = left / (kValuesOfOneSky * (sums.rr + stiffness) * square(exponent));
      const double likelihood = std::exp(-0.5 * square(off)) * std::pow(left, -0.5 * kValuesOfOneSky);
      step.likelihood += likelihood;
      step.rim_loss += likelihood * loss;
      step.rim_square += likelihood * (square(loss) + variance);
    }
    most = std::max(most, step.likelihood);
    steps.push_back(step);
  }
  double sum = 0.0, first = 0.0, second = 0.0, rim = 0.0, rim_square = 0.0;
  for (const Step& step : steps) {
    const double weight = step.likelihood / most;
    sum += weight, first += weight * step.log_exponent, second += weight * square(step.log_exponent);
    rim += step.rim_loss / most, rim_square += step.rim_square / most;
  }
  const auto moments = [&](double one, double two) {
    return Moments{one / sum, std::sqrt(std::max(0.0, two / sum - square(one / sum)))};
  };
  return {moments(first, second), moments(rim, rim_square)};
}

std::vector<SkyReading> undone(std::span<const SkyReading> readings, double exponent) {
  std::vector<SkyReading> made(readings.begin(), readings.end());
  for (SkyReading& reading : made) {
    reading.light = glm::pow(reading.light, glm::dvec3{1.0 / exponent});
    reading.sigma /= exponent;
  }
  return made;
}

// Moments over the tone exponents, added to those of the middle one.
void mix(SkyFit& middle, std::span<const SkyFit> fits, std::span<const double> weights) {
  double aod = 0.0, exponent = 0.0, turbidity = 0.0, sum = 0.0;
  AerosolCovariance c{0.0, 0.0, 0.0};
  double turbidity_square = 0.0;
  std::remove_reference_t<decltype(middle.found.kinds)> kinds{};
  for (std::size_t i = 0; i < fits.size(); ++i) {
    if (!fits[i].solved) continue;
    const auto& [aerosol, covariance] = std::tie(fits[i].found.aerosol, fits[i].found.covariance);
    const double w = weights[i];
    sum += w;
    aod += w * aerosol.aod_550;
    exponent += w * aerosol.angstrom_exponent;
    turbidity += w * fits[i].turbidity.value;
    c.aod_550 += w * (covariance.aod_550 + square(aerosol.aod_550));
    c.aod_and_exponent += w * (covariance.aod_and_exponent + aerosol.aod_550 * aerosol.angstrom_exponent);
    c.angstrom_exponent += w * (covariance.angstrom_exponent + square(aerosol.angstrom_exponent));
    turbidity_square += w * (square(fits[i].sigma_turbidity) + square(fits[i].turbidity.value));
    for (std::size_t k = 0; k < kinds.size(); ++k) kinds[k] += w * fits[i].found.kinds[k];
  }
  aod /= sum, exponent /= sum, turbidity /= sum;
  middle.found.aerosol.aod_550 = aod;
  middle.found.aerosol.angstrom_exponent = exponent;
  middle.found.covariance = {std::max(0.0, c.aod_550 / sum - square(aod)), c.aod_and_exponent / sum - aod * exponent,
                             std::max(0.0, c.angstrom_exponent / sum - square(exponent))};
  for (std::size_t k = 0; k < kinds.size(); ++k) middle.found.kinds[k] = kinds[k] / sum;
  const auto likeliest = std::ranges::max_element(middle.found.kinds) - middle.found.kinds.begin();
  middle.found.aerosol.kind = kAerosolKinds[static_cast<std::size_t>(likeliest)];
  middle.turbidity = Turbidity{turbidity};
  middle.sigma_turbidity = std::sqrt(std::max(0.0, turbidity_square / sum - square(turbidity)));
}

// What a standard deviation of the altitude changes is one more of every answer.
void add_altitude(SkyFit& fit, const SkyFit& here, const SkyFit& higher) {
  if (!higher.solved) return;
  const double aod = higher.found.aerosol.aod_550 - here.found.aerosol.aod_550;
  const double exponent = higher.found.aerosol.angstrom_exponent - here.found.aerosol.angstrom_exponent;
  fit.found.covariance.aod_550 += square(aod);
  fit.found.covariance.aod_and_exponent += aod * exponent;
  fit.found.covariance.angstrom_exponent += square(exponent);
  fit.sigma_turbidity = std::hypot(fit.sigma_turbidity, higher.turbidity.value - here.turbidity.value);
}

}  // namespace

UncalibratedFit fit_unknown_camera(std::span<const SkyReading> readings, const SunDirection& sun, const ModelToFit& sky,
                                   const CameraBelief& belief) {
  UncalibratedFit found;
  if (readings.empty()) return found;
  const auto [tone, rim] = instrument_of(readings, sun, sky.altitude_m, belief);
  found.exponent = std::exp(tone.mean);
  found.sigma_exponent = found.exponent * tone.sigma;
  found.rim_loss = rim.mean;
  found.sigma_rim_loss = rim.sigma;
  const InstrumentDoubt doubt{true, belief.white_balance, belief.rim_loss};
  // Gauss and Hermite's three points.
  const double step = std::sqrt(3.0) * tone.sigma;
  const std::array<double, 3> at{tone.mean, tone.mean - step, tone.mean + step},
      weights{2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0};
  std::array<SkyFit, 3> fits;
  for (std::size_t i = 0; i < at.size(); ++i) fits[i] = fit_sky(undone(readings, std::exp(at[i])), sun, sky, doubt);
  found.sky = fits[0];
  if (!found.sky.solved) return found;
  mix(found.sky, fits, weights);
  if (belief.sigma_altitude_m > 0.0) {
    ModelToFit higher = sky;
    higher.altitude_m += belief.sigma_altitude_m;
    add_altitude(found.sky, fits[0], fit_sky(undone(readings, std::exp(tone.mean)), sun, higher, doubt));
  }
  found.log_residual = found.sky.log_residual;
  return found;
}

}  // namespace kasumi
