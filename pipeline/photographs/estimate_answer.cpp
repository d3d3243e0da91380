#include "pipeline/photographs/estimate_answer.hpp"

#include <cmath>

#include <nlohmann/json.hpp>

namespace kasumi {

std::string estimate_json(const std::filesystem::path& image, const SkyPhotographReport& report,
                          const std::string& landmarks) {
  const auto& estimate = report.look.estimate;
  // Dividing by a power of ten gives the double that prints with that many digits; multiplying by its inverse does not.
  const auto rounded = [](double value, int digits) {
    const double scale = std::pow(10.0, digits);
    return std::round(value * scale) / scale;
  };
  nlohmann::ordered_json json;
  json["image"] = image.string();
  json["turbidity"] = nullptr;
  json["sigma"] = nullptr;
  if (estimate.usable) {
    json["turbidity"] = rounded(estimate.turbidity.value, 5);
    json["sigma"] = rounded(estimate.sigma, 6);
  }
  json["usable"] = estimate.usable;
  json["reason"] = estimate.reason;
  json["sky"] = name_of(estimate.sky);
  json["clear_fraction"] = rounded(estimate.clear_fraction, 4);
  json["samples"] = estimate.samples;
  json["log_residual"] = rounded(estimate.log_residual, 5);
  json["sky_model"] = name_of(report.look.sky.model);
  json["sun_zenith_deg"] = nullptr;
  json["sun_azimuth_deg"] = nullptr;
  if (report.sun) {
    json["sun_zenith_deg"] = rounded(to_degrees(zenith_angle(*report.sun)), 4);
    json["sun_azimuth_deg"] = rounded(to_degrees(azimuth_angle(*report.sun)), 4);
  }
  json["sun_from"] = report.sun_source;
  json["aod_550"] = nullptr;
  json["angstrom_exponent"] = nullptr;
  json["aerosol"] = nullptr;
  json["visibility_m"] = nullptr;
  json["weather"] = nullptr;
  if (report.air) {
    json["aod_550"] = rounded(report.air->aod_550, 5);
    if (const auto& aerosol = report.air->aerosol) {
      json["angstrom_exponent"] = rounded(aerosol->angstrom_exponent, 3);
      json["aerosol"] = name_of(aerosol->kind);
    }
    json["visibility_m"] = rounded(report.air->visibility_m, 0);
    json["weather"] = name_of(report.air->weather);
  }
  if (report.circle)
    json["circle"] = {rounded(report.circle->centre.x, 2), rounded(report.circle->centre.y, 2),
                      rounded(report.circle->radius_px, 2)};
  if (!landmarks.empty()) json["landmarks"] = nlohmann::ordered_json::parse(landmarks);
  return json.dump() + "\n";
}

std::string estimate_text(const std::filesystem::path& image, const SkyPhotographReport& report) {
  const auto& estimate = report.look.estimate;
  std::string text = image.string() + "\n";
  if (estimate.usable && report.air) {
    text += fmt::format("  turbidity        {:.3f} +- {:.3f}{}\n", estimate.turbidity.value, estimate.sigma,
                        report.look.sky.model == SiteSkyModel::dome
                            ? fmt::format(" (of the dome, seen from {:.0f} m)", report.look.sky.altitude_m)
                            : "");
    text += fmt::format("  aerosol depth    {:.3f} at 550 nm", report.air->aod_550);
    if (const auto& aerosol = report.air->aerosol)
      text += fmt::format(", exponent {:.2f}, {}", aerosol->angstrom_exponent, name_of(aerosol->kind));
    text += "\n";
    text += fmt::format("  visibility       {:.1f} km\n", report.air->visibility_m / 1000.0);
    text += fmt::format("  weather          {}\n", name_of(report.air->weather));
  } else {
    text += fmt::format("  not usable       {}\n", estimate.reason);
  }
  text += fmt::format("  sky              {}, {:.0f} % of the samples are clear\n", name_of(estimate.sky),
                      100.0 * estimate.clear_fraction);
  if (report.sun)
    text += fmt::format("  sun              zenith {:.2f} deg, azimuth {:.2f} deg{}\n",
                        to_degrees(zenith_angle(*report.sun)), to_degrees(azimuth_angle(*report.sun)),
                        report.sun_source.empty() ? "" : " (" + report.sun_source + ")");
  if (estimate.usable)
    text += fmt::format("  fit              {} samples agree within {:.1f} % (rms)\n", estimate.samples,
                        100.0 * estimate.log_residual);
  if (report.circle)
    text += fmt::format("  image circle     centre ({:.1f}, {:.1f}), radius {:.1f} px\n", report.circle->centre.x,
                        report.circle->centre.y, report.circle->radius_px);
  return text;
}

}  // namespace kasumi
