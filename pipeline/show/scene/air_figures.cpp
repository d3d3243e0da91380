#include "pipeline/show/scene/air_figures.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace kasumi {

double aod_sigma(const TrackedAir& state) {
  if (state.air.aerosol_known()) return std::sqrt(state.air.covariance().aod_550);
  // The optical depth is linear in T.
  const double exponent = state.air.aerosol().angstrom_exponent;
  return state.sigma_turbidity * (aerosol_of(3.0, exponent).aod_550 - aerosol_of(2.0, exponent).aod_550);
}

double angstrom_sigma(const TrackedAir& state) {
  return std::sqrt(state.air.covariance().angstrom_exponent);
}

std::optional<AirQuality> seen_quality(const SkyReport& report, double altitude_m) {
  const auto* air = report.seen_air();
  return air ? std::optional(air_quality(air->air, altitude_m)) : std::nullopt;
}

std::string observers_text(const TrackedAir& state) {
  if (state.observers.empty()) return std::string(name_of(AirObserver::supposed));
  std::string text;
  for (const ObserverPart& part : state.observers)
    text += fmt::format("{}{} {:.2f}", text.empty() ? "" : ", ", name_of(part.by), part.share);
  return text;
}

double largest_disagreement_sigmas(const TrackedAir& state) {
  double largest = 0.0;
  for (const ObserverPart& part : state.observers)
    if (std::abs(part.apart_sigmas) > std::abs(largest)) largest = part.apart_sigmas;
  return largest;
}

}  // namespace kasumi
