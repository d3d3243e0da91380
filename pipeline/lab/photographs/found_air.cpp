#include "pipeline/lab/photographs/found_air.hpp"

#include <cmath>

#include "estimator/given_air.hpp"

namespace kasumi {
namespace {

// Where the sky is the papers', T is all that is known of the air.
bool aerosol_followed(const TurbidityEstimate& estimate) {
  return estimate.found && estimate.found->papers_share <= 0.5;
}

}  // namespace

AirState found_air(const TurbidityEstimate& estimate, const ModelToFit& followed) {
  if (aerosol_followed(estimate)) return {estimate.found->aerosol, estimate.found->covariance};
  const auto given = followed.every_model ? followed.known.to_be_found() : followed.aerosol;
  return air_of(estimate.turbidity, given, estimate.sigma);
}

AerosolSigmas aerosol_sigmas(const TurbidityEstimate& estimate, const AirState& air) {
  if (aerosol_followed(estimate))
    return {std::sqrt(estimate.found->covariance.aod_550), std::sqrt(estimate.found->covariance.angstrom_exponent)};
  const auto like = air.aerosol_known() ? air.aerosol() : Aerosol{};
  const double formal = std::sqrt(air_of(estimate.turbidity, like, estimate.sigma).covariance().aod_550);
  return {estimate.found ? std::sqrt(estimate.found->covariance.aod_550) : formal, std::nullopt};
}

}  // namespace kasumi
