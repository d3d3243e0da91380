#include "estimator/fusion/lasting_errors.hpp"

#include <algorithm>
#include <cmath>

namespace kasumi {
namespace {

// Chosen: shorter than an error lasts (six hours), longer than a passing cloud.
constexpr Duration kSigmaAveragedOver = std::chrono::minutes(30);

}  // namespace

LastingErrors::Parts LastingErrors::parts(GaussMarkov& state, std::size_t error, double sigma, Instant when) {
  const auto [known, first] = usual_.try_emplace(error, Usual{sigma, when});
  Usual& usual = known->second;
  if (!first) {
    const double passed = std::max(0.0, to_seconds(when - usual.when) / to_seconds(kSigmaAveragedOver));
    const double before = usual.sigma;
    usual.sigma *= std::pow(sigma / before, 1.0 - std::exp(-passed));
    usual.when = std::max(usual.when, when);
    state.forget(error, std::min(usual.sigma / before, before / usual.sigma));
  }
  const double lasting = std::sqrt(share_) * usual.sigma;
  const double passing = std::max((1.0 - share_) * sigma * sigma, sigma * sigma - lasting * lasting);
  return {lasting, std::sqrt(passing)};
}

}  // namespace kasumi
