#include "pipeline/lab/photographs/estimate_answer.hpp"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "base/outside/json_text.hpp"
#include "base/utc_text.hpp"
#include "pipeline/lab/photographs/found_air.hpp"
#include "pipeline/lab/photographs/sky_model_choice.hpp"

namespace kasumi {
namespace {

// Hosek's sky knows no kinds.
bool kind_known(const TurbidityEstimate& estimate) {
  return !estimate.found || std::ranges::any_of(estimate.found->kinds, [](double share) { return share > 0.0; });
}

// "0.094 +- 0.012 at 550 nm, exponent 1.32 +- 0.20, continental"
std::string aerosol_text(const PhotographReport& report) {
  const auto sigmas = aerosol_sigmas(report.look.estimate, *report.air);
  std::string text =
      fmt::format("  aerosol depth    {:.3f} +- {:.3f} at 550 nm", report.quality->aod_550, sigmas.aod_550);
  if (const auto& aerosol = report.quality->aerosol) {
    text += fmt::format(", exponent {:.2f}", aerosol->angstrom_exponent);
    if (sigmas.angstrom_exponent) text += fmt::format(" +- {:.2f}", *sigmas.angstrom_exponent);
    if (kind_known(report.look.estimate)) text += fmt::format(", {}", name_of(aerosol->kind));
  }
  return text + "\n";
}

// The models with their weights: "dome, continental 71 %; preetham 20 %".
std::string models_text(const std::vector<ModelAnswer>& models) {
  constexpr double kWorthTelling = 0.005;
  std::string text;
  for (const auto& model : models)
    if (model.weight >= kWorthTelling)
      text += fmt::format("{}{} {:.0f} %", text.empty() ? "" : "; ", model.name, 100.0 * model.weight);
  return text.empty() ? "" : "  by               " + text + "\n";
}

// A scan has no cloud cover; its verdict may still give the kind of sky.
CoverClass sky_class(const PhotographReport& report) {
  if (report.cover.sky != CoverClass::unknown) return report.cover.sky;
  switch (report.look.estimate.sky) {
    case SkyCondition::night: return CoverClass::night;
    case SkyCondition::overcast: return CoverClass::overcast;
    case SkyCondition::clear: return CoverClass::clear;
    default: return CoverClass::unknown;
  }
}

// "few, 23 +- 8 % cloud"
std::string sky_text(const PhotographReport& report) {
  const auto& cover = report.cover;
  std::string text = fmt::format("  sky              {}", name_of(sky_class(report)));
  if (cover.fraction) text += fmt::format(", {:.0f} +- {:.0f} % cloud", 100.0 * *cover.fraction, 100.0 * cover.sigma);
  if (const auto& estimate = report.look.estimate; estimate.usable)
    text +=
        fmt::format("; {}, {:.0f} % of the samples are clear", name_of(estimate.sky), 100.0 * estimate.clear_fraction);
  return text + "\n";
}

// "46.940 N, 8.280 E, 460 m"
std::string place_text(const PhotographReport& report) {
  const auto& place = *report.taken.place;
  return fmt::format("{:.3f} {}, {:.3f} {}{}", std::abs(place.latitude_deg), place.latitude_deg < 0.0 ? "S" : "N",
                     std::abs(place.longitude_deg), place.longitude_deg < 0.0 ? "W" : "E",
                     place.altitude_m ? fmt::format(", {:.0f} m", *place.altitude_m) : "");
}

}  // namespace

std::string other_place(const PhotographReport& report) {
  return fmt::format("its {} says {}, {:.0f} km away", report.taken.by, place_text(report), *report.off_m / 1000.0);
}

std::string estimate_json(const std::filesystem::path& image, const PhotographReport& report,
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
  const auto& cover = report.cover;
  json["sky"] = nullptr;
  if (const auto sky = sky_class(report); sky != CoverClass::unknown) json["sky"] = name_of(sky);
  json["cloud_fraction"] = nullptr;
  json["sigma_cloud_fraction"] = nullptr;
  if (cover.fraction) {
    json["cloud_fraction"] = rounded(*cover.fraction, 4);
    json["sigma_cloud_fraction"] = rounded(cover.sigma, 4);
  }
  json["verdict"] = name_of(estimate.sky);
  json["clear_fraction"] = rounded(estimate.clear_fraction, 4);
  json["samples"] = estimate.samples;
  json["log_residual"] = rounded(estimate.log_residual, 5);
  json["sky_model"] = followed_model(report.look.sky);
  json["sun_zenith_deg"] = nullptr;
  json["sun_azimuth_deg"] = nullptr;
  if (report.sun.direction) {
    json["sun_zenith_deg"] = rounded(to_degrees(zenith_angle(*report.sun.direction)), 4);
    json["sun_azimuth_deg"] = rounded(to_degrees(azimuth_angle(*report.sun.direction)), 4);
  }
  json["sun_sigma_deg"] = nullptr;
  if (report.sun.seen) json["sun_sigma_deg"] = rounded(to_degrees(report.sun.seen->sigma), 3);
  json["sun_from"] = report.sun.told;
  json["sun_seen"] = nullptr;
  if (report.sun.seen) {
    json["sun_seen"] = {{"zenith_deg", rounded(to_degrees(zenith_angle(*report.sun.seen_at)), 3)},
                        {"azimuth_deg", rounded(to_degrees(azimuth_angle(*report.sun.seen_at)), 3)},
                        {"sigma_deg", rounded(to_degrees(report.sun.seen->sigma), 3)},
                        {"confidence", rounded(report.sun.seen->confidence, 4)},
                        {"disagreement_deg", nullptr}};
    if (report.sun.disagreement)
      json["sun_seen"]["disagreement_deg"] = rounded(to_degrees(*report.sun.disagreement), 3);
  }
  json["orientation"] = nullptr;
  json["azimuth_up_deg"] = nullptr;
  if (report.picture) json["orientation"] = name_of(report.sun.orientation);
  if (report.picture && report.circle) json["azimuth_up_deg"] = rounded(degrees_of_azimuth(report.sun.azimuth_up), 3);
  json["damaged"] = nullptr;
  if (!report.damage.empty()) json["damaged"] = report.damage;
  for (const char* key :
       {"aod_550", "sigma_aod_550", "angstrom_exponent", "sigma_angstrom", "aerosol", "visibility_m", "weather"})
    json[key] = nullptr;
  if (report.air && report.quality) {
    const auto sigmas = aerosol_sigmas(estimate, *report.air);
    json["aod_550"] = rounded(report.quality->aod_550, 5);
    json["sigma_aod_550"] = rounded(sigmas.aod_550, 5);
    if (const auto& aerosol = report.quality->aerosol) {
      json["angstrom_exponent"] = rounded(aerosol->angstrom_exponent, 3);
      if (sigmas.angstrom_exponent) json["sigma_angstrom"] = rounded(*sigmas.angstrom_exponent, 3);
      if (kind_known(estimate)) json["aerosol"] = name_of(aerosol->kind);
    }
    json["visibility_m"] = rounded(report.quality->visibility_m, 0);
    json["weather"] = name_of(report.quality->weather);
  }
  json["models"] = nlohmann::ordered_json::array();
  for (const auto& model : estimate.models)
    json["models"].push_back({{"name", model.name},
                              {"turbidity", rounded(model.turbidity.value, 4)},
                              {"aod_550", rounded(model.aod_550, 5)},
                              {"log_residual", rounded(model.log_residual, 5)},
                              {"weight", rounded(model.weight, 4)}});
  const auto circle = [&](const ImageCircle& c) {
    return nlohmann::ordered_json{rounded(c.centre.x, 2), rounded(c.centre.y, 2), rounded(c.radius_px, 2)};
  };
  json["horizon_circle"] = nullptr;
  if (report.circle) {
    json["circle"] = circle(*report.circle);
    json["circle_sigma_px"] = rounded(report.circle->sigma_px, 2);
    json["circle_confidence"] = rounded(report.circle_confidence, 3);
    json["pixel_aspect"] = rounded(report.pixel_aspect, 4);
  }
  if (report.horizon_circle) json["horizon_circle"] = circle(*report.horizon_circle);
  json["mirrored"] = nullptr;
  if (report.sun.orientation == Orientation::from_series) json["mirrored"] = report.mirrored;
  if (report.tone) {
    json["tone_exponent"] = rounded(report.tone->exponent, 4);
    json["sigma_tone_exponent"] = rounded(report.tone->sigma, 4);
  }
  json["taken"] = nullptr;
  if (const auto& taken = report.taken; !taken.by.empty()) {
    auto& told = json["taken"] = {{"by", taken.by},
                                  {"utc", nullptr},
                                  {"latitude_deg", nullptr},
                                  {"longitude_deg", nullptr},
                                  {"altitude_m", nullptr},
                                  {"time_used", report.utc_by_file},
                                  {"place_used", report.site_by_file},
                                  {"off_km", nullptr}};
    if (taken.utc) told["utc"] = utc_text(*taken.utc);
    if (taken.place) {
      told["latitude_deg"] = rounded(taken.place->latitude_deg, 5);
      told["longitude_deg"] = rounded(taken.place->longitude_deg, 5);
      if (taken.place->altitude_m) told["altitude_m"] = rounded(*taken.place->altitude_m, 1);
    }
    if (report.off_m) told["off_km"] = rounded(*report.off_m / 1000.0, 1);
  }
  json["stack"] = nullptr;
  if (!report.stack.empty()) {
    auto images = nlohmann::ordered_json::array(), ratios = nlohmann::ordered_json::array();
    for (const auto& exposure : report.stack) images.push_back(exposure.string());
    for (const double ratio : report.exposure_ratios) ratios.push_back(rounded(ratio, 3));
    json["stack"] = {{"images", std::move(images)}, {"exposure_ratios", std::move(ratios)}};
  }
  if (!landmarks.empty()) json["landmarks"] = parse_ordered_json(landmarks);
  return text_of_json(json) + "\n";
}

std::string estimate_text(const std::filesystem::path& image, const PhotographReport& report) {
  const auto& estimate = report.look.estimate;
  std::string text = image.string() + "\n";
  if (estimate.usable && report.air && report.quality) {
    text += fmt::format("  turbidity        {:.3f} +- {:.3f}{}\n", estimate.turbidity.value, estimate.sigma,
                        followed_model(report.look.sky) == name_of(DaylightModel::dome)
                            ? fmt::format(" (of the dome, seen from {:.0f} m)", report.look.sky.altitude_m)
                            : "");
    text += aerosol_text(report) + models_text(estimate.models);
    text += fmt::format("  visibility       {:.1f} km\n", report.quality->visibility_m / 1000.0);
    text += fmt::format("  weather          {}\n", name_of(report.quality->weather));
  } else {
    text += fmt::format("  not usable       {}\n", estimate.reason);
  }
  text += sky_text(report);
  if (const auto& sun = report.sun.direction)
    text += fmt::format("  sun              zenith {:.2f} deg, azimuth {:.2f} deg{}\n", to_degrees(zenith_angle(*sun)),
                        to_degrees(azimuth_angle(*sun)), report.sun.told.empty() ? "" : " (" + report.sun.told + ")");
  if (!report.sun.orientation_told.empty()) text += fmt::format("  orientation      {}\n", report.sun.orientation_told);
  if (report.utc_by_file) text += fmt::format("  time             {}, by {}\n", utc_text(*report.utc), report.taken.by);
  if (report.site_by_file) text += fmt::format("  place            {}, by {}\n", place_text(report), report.taken.by);
  if (report.off_m) text += "  place            as given; " + other_place(report) + "\n";
  if (!report.damage.empty())
    text += fmt::format("  damaged          {}; what is left of it was used\n", report.damage);
  if (estimate.usable)
    text += fmt::format("  fit              {} samples agree within {:.1f} % (rms)\n", estimate.samples,
                        100.0 * estimate.log_residual);
  if (report.tone)
    text +=
        fmt::format("  tone curve       sRGB to the power {:.3f} +- {:.3f}, from {} picture{}\n", report.tone->exponent,
                    report.tone->sigma, report.tone->pictures, report.tone->pictures == 1 ? "" : "s");
  if (report.circle)
    text += fmt::format("  image circle     centre ({:.1f}, {:.1f}), radius {:.1f} px\n", report.circle->centre.x,
                        report.circle->centre.y, report.circle->radius_px);
  if (report.horizon_circle)
    text +=
        fmt::format("  horizon circle   centre ({:.1f}, {:.1f}), radius {:.1f} px\n", report.horizon_circle->centre.x,
                    report.horizon_circle->centre.y, report.horizon_circle->radius_px);
  if (report.pixel_aspect != 1.0) text += fmt::format("  pixels           are 1 : {:.3f}\n", report.pixel_aspect);
  return text;
}

}  // namespace kasumi
