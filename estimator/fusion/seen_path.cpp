#include "estimator/fusion/seen_path.hpp"

#include <algorithm>
#include <cmath>

#include "base/aerosol.hpp"
#include "estimator/air/scattering.hpp"
#include "estimator/fusion/air_quantities.hpp"

namespace kasumi {
namespace {

using Kind = PathReading::Channel::Kind;

constexpr double kLeastPathAod = 1e-4;  // so that its logarithm can be taken

bool possible(const PathReading::Channel& channel) {
  return channel.kind != Kind::nothing && std::isfinite(channel.per_m) && std::isfinite(channel.sigma_per_m) &&
         channel.sigma_per_m > 0.0;
}

}  // namespace

SeenChannel::Sum SeenChannel::sum(const GaussMarkov& state) const {
  const double at_550 =
      std::max(kLeastPathAod, std::exp(state.mean(kAmount) + state.mean(kNearGround)) - kSmallAerosol);
  const double log_wavelength = std::log(wavelength_nm / 550.0);
  const double ratio = std::exp(-state.mean(kExponent) * log_wavelength);
  const double here = at_550 * ratio;
  Sum sum{GaussMarkov::Row(kAirQuantities, 0.0), {}};
  sum.row[kAmount] = sum.row[kNearGround] = ratio * (at_550 + kSmallAerosol) / (here + kSmallAerosol);
  sum.row[kExponent] = -log_wavelength * here / (here + kSmallAerosol);
  sum.row[kPathError] = lasting_shared;
  sum.row[error] = lasting;
  sum.expected = {log_amount(here) + lasting_shared * state.mean(kPathError) + lasting * state.mean(error),
                  state.sum(sum.row).variance};
  return sum;
}

double SeenChannel::beyond(double log_amount_there) const {
  const double off = log_amount(aod) - log_amount_there;
  if (kind == Kind::at_most) return std::min(0.0, off);
  if (kind == Kind::at_least) return std::max(0.0, off);
  return off;
}

double SeenChannel::log_likelihood(double log_amount_there, double sigma_there) const {
  const double off = aod - (std::exp(log_amount_there) - kSmallAerosol);
  if ((kind == Kind::at_most && off > 0.0) || (kind == Kind::at_least && off < 0.0)) return 0.0;
  return -0.5 * (off / sigma_there) * (off / sigma_there);
}

std::vector<SeenChannel> seen_path(const PathReading& reading, double altitude_m, GaussMarkov& state,
                                   LastingErrors& errors, Instant when) {
  if (!std::isfinite(reading.shared_sigma)) return {};
  std::vector<SeenChannel> seen;
  const double depth_m = kAerosolHeight_m * std::exp(altitude_m / kAerosolHeight_m);
  for (std::size_t c = 0; c < reading.channels.size(); ++c) {
    const auto& channel = reading.channels[c];
    if (!possible(channel)) continue;
    SeenChannel one{channel.kind, kRedError + c, channel.wavelength_nm};
    one.aod = depth_m * (channel.per_m - rayleigh_per_m(ScatteringModel::aerosol, channel.wavelength_nm, altitude_m));
    one.sigma = depth_m * channel.sigma_per_m;
    one.shared_sigma = depth_m * channel.per_m * std::max(0.0, reading.shared_sigma);
    seen.push_back(one);
  }
  std::ranges::sort(seen, {}, [](const SeenChannel& one) { return std::abs(one.wavelength_nm - 550.0); });

  // Weights the channels equally for their shared error: with individual weights, small differences between channels
  // would make that error seem observable. Such differences belong to each channel's own error.
  double shared = 0.0, lasting_shared = 0.0;
  for (SeenChannel& one : seen) {
    const double shared_here = log_sigma(one.aod, one.shared_sigma);
    if (&one == &seen.front() && shared_here > 0.0) {
      shared = shared_here;
      lasting_shared = errors.parts(state, kPathError, shared, when).lasting;
    }
    const double own = log_sigma(one.aod, one.sigma);
    const auto parts = errors.parts(state, one.error, std::hypot(own, shared_here - shared), when);
    one.lasting = parts.lasting;
    one.lasting_shared = lasting_shared;
    one.passing_share = parts.passing / own;
  }
  return seen;
}

}  // namespace kasumi
