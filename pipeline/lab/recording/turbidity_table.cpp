#include "pipeline/lab/recording/turbidity_table.hpp"

#include "base/files.hpp"
#include "base/utc_text.hpp"
#include "pipeline/show/scene/air_figures.hpp"

namespace kasumi {

namespace {

constexpr std::string_view kHeader =
    "utc,usable,sky,turbidity,sigma,shown_turbidity,shown_sigma,age_s,trustworthy,aod_550,visibility_m,weather,"
    "clear_fraction,samples,log_residual,sun_zenith_deg,sun_azimuth_deg,reason,"
    "sigma_aod_550,angstrom_exponent,sigma_angstrom,aerosol,near_ground,sigma_log_near_ground,papers_share,supposed,"
    "observers,sigmas_apart,air";

std::string quoted(std::string text) {
  for (std::size_t at = 0; (at = text.find('"', at)) != std::string::npos; at += 2) text.insert(at, 1, '"');
  return '"' + text + '"';
}

std::string number_if(bool valid, double value, int digits) {
  return valid ? fmt::format("{:.{}f}", value, digits) : "";
}

// The state of the air; empty while there is none.
std::string state_fields(const std::optional<TrackedAir>& state) {
  if (!state) return ",,,,,,,,,,";
  const Aerosol& aerosol = state->air.aerosol();
  return fmt::format("{:.4f},{:.3f},{:.3f},{},{:.4f},{:.4f},{:.3f},{},{},{:.2f},{}", aod_sigma(*state),
                     aerosol.angstrom_exponent, angstrom_sigma(*state), name_of(aerosol.kind), state->air.near_ground(),
                     state->sigma_log_near_ground, state->papers_share, state->supposed, quoted(observers_text(*state)),
                     largest_disagreement_sigmas(*state), quoted(state->text()));
}

}  // namespace

void TurbidityTable::add(const SkyReport& report, double altitude_m) {
  const auto& estimate = report.estimate;
  const auto* seen = report.seen_air();
  const auto air = seen_quality(report, altitude_m);
  const bool sun = report.sun.source != SunSource::none;
  rows_.push_back(fmt::format(
      "{},{},{},{},{},{},{},{},{},{},{},{},{:.4f},{},{:.4f},{},{},{},{}", utc_text(report.utc), estimate.usable,
      name_of(estimate.sky), number_if(estimate.usable, estimate.turbidity.value, 4),
      number_if(estimate.usable, estimate.sigma, 4), number_if(seen, seen ? seen->air.turbidity().value : 0, 4),
      number_if(seen, seen ? seen->sigma_turbidity : 0, 4), number_if(seen, seen ? to_seconds(seen->age) : 0, 1),
      seen && seen->trustworthy, number_if(air.has_value(), air ? air->aod_550 : 0, 4),
      number_if(air.has_value(), air ? air->visibility_m : 0, 0), air ? name_of(air->weather) : "",
      estimate.clear_fraction, estimate.samples, estimate.log_residual,
      number_if(sun, to_degrees(zenith_angle(report.sun.direction)), 4),
      number_if(sun, to_degrees(azimuth_angle(report.sun.direction)), 4), quoted(estimate.reason),
      state_fields(report.air)));
}

Result<> TurbidityTable::write(const std::filesystem::path& path) const {
  return write_text_file(path, fmt::format("{}\n{}\n", kHeader, fmt::join(rows_, "\n")));
}

}  // namespace kasumi
