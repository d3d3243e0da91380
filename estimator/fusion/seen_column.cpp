#include "estimator/fusion/seen_column.hpp"

#include <algorithm>
#include <cmath>

#include "estimator/fusion/air_quantities.hpp"

namespace kasumi {
namespace {

// Chosen: below, rounding in an estimate could pass for certainty.
constexpr double kLeastLogSigma = 0.005, kLeastExponentSigma = 0.01;

bool possible(const FoundAerosol& found) {
  const AerosolCovariance& of = found.covariance;
  return std::isfinite(found.aerosol.aod_550) && std::isfinite(found.aerosol.angstrom_exponent) &&
         std::isfinite(of.aod_550) && std::isfinite(of.angstrom_exponent) && std::isfinite(of.aod_and_exponent) &&
         of.aod_550 >= 0.0 && of.angstrom_exponent >= 0.0;
}

}  // namespace

std::optional<SeenColumn> seen_column(const ColumnReading& reading, GaussMarkov& state, LastingErrors& errors,
                                      Instant when) {
  if (!possible(reading.found)) return std::nullopt;
  const Aerosol& aerosol = reading.found.aerosol;
  const AerosolCovariance& of = reading.found.covariance;
  const double sigma = std::max(kLeastLogSigma, log_sigma(aerosol.aod_550, std::sqrt(of.aod_550)));
  // How the exponent's error goes with the amount's, and what is left of it.
  const double per_log = of.aod_550 > 0.0 ? sigma / std::sqrt(of.aod_550) : 0.0;
  const double along = per_log * of.aod_and_exponent / (sigma * sigma);
  const double left = std::sqrt(
      std::max(kLeastExponentSigma * kLeastExponentSigma, of.angstrom_exponent - along * along * sigma * sigma));

  const bool by_horizon = reading.by == AirObserver::horizon;
  const auto amount_error = by_horizon ? kHorizonAmountError : kSkyAmountError;
  const auto exponent_error = by_horizon ? kHorizonExponentError : kSkyExponentError;
  const auto amount_parts = errors.parts(state, amount_error, sigma, when);
  const auto exponent_parts = errors.parts(state, exponent_error, left, when);

  SeenColumn seen;
  seen.amount = {log_amount(aerosol.aod_550), sigma * sigma};
  seen.exponent = aerosol.angstrom_exponent;
  seen.exponent_sigma = left;
  seen.amount_error = amount_error;
  seen.exponent_error = exponent_error;
  seen.amounts = {GaussMarkov::Row(kAirQuantities, 0.0), seen.amount.mean, amount_parts.passing};
  seen.amounts.row[kAmount] = 1.0;
  seen.amounts.row[amount_error] = amount_parts.lasting;
  seen.exponents = {GaussMarkov::Row(kAirQuantities, 0.0), seen.exponent - along * seen.amount.mean,
                    exponent_parts.passing};
  seen.exponents.row[kExponent] = 1.0;
  seen.exponents.row[kAmount] = -along;
  seen.exponents.row[exponent_error] = exponent_parts.lasting;
  return seen;
}

}  // namespace kasumi
