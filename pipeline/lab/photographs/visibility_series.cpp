#include "pipeline/lab/photographs/visibility_series.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include <nlohmann/json.hpp>

#include "base/outside/json_text.hpp"
#include "estimator/photograph/other_air.hpp"
#include "pipeline/site/config/descriptions.hpp"
#include "pipeline/site/files/photograph_file.hpp"
#include "pipeline/site/files/picture_source.hpp"

namespace kasumi {
namespace {

using Json = nlohmann::ordered_json;

std::vector<std::filesystem::path> files_of(const std::vector<std::filesystem::path>& given) {
  std::vector<std::filesystem::path> files;
  for (const auto& path : given) {
    std::error_code error;
    if (std::filesystem::is_directory(path, error))
      std::ranges::move(pictures_in(path), std::back_inserter(files));
    else
      files.push_back(path);
  }
  return files;
}

// Dividing by a power of ten gives the double that prints with that many digits.
double rounded(double value, int significant) {
  if (value == 0.0 || !std::isfinite(value)) return value;
  const int digits = significant - 1 - static_cast<int>(std::floor(std::log10(std::abs(value))));
  const double scale = std::pow(10.0, std::abs(digits));
  return digits >= 0 ? std::round(value * scale) / scale : std::round(value / scale) * scale;
}

template <class Of>
Json per_channel(const ChannelExtinctions& air, Of of) {
  Json list = Json::array();
  for (const auto& channel : air.channels) list.push_back(rounded(of(channel), 4));
  return list;
}

std::string_view visibility_name(ExtinctionKind kind) {
  switch (kind) {
    case ExtinctionKind::at_most: return "at least";
    case ExtinctionKind::at_least: return "at most";
    case ExtinctionKind::value: return "value";
    case ExtinctionKind::nothing: break;
  }
  return "nothing";
}

}  // namespace

Result<VisibilitySeries> read_visibilities(const std::vector<std::filesystem::path>& pictures,
                                           const std::filesystem::path& landmarks) {
  const auto files = files_of(pictures);
  if (files.empty()) return fail(FaultKind::bad_input, "--scene: no pictures found");
  std::optional<LandmarkWatch> watch;
  Camera camera;
  std::vector<std::vector<ContrastReading>> readings;
  for (const auto& file : files) {
    const auto photograph = read_photograph(file);
    if (!photograph) return fail(photograph.error());
    const int width = photograph->encoded.width(), height = photograph->encoded.height();
    if (!watch) {
      auto read = read_landmark_file(landmarks, width, height);
      if (!read) return fail(read.error());
      camera = read->scene.value_or(plain_camera(width, height, from_degrees(50.0), Radians{0.0}));
      watch.emplace(camera, read->altitude_m, std::move(read->landmarks));
    }
    if (width != camera.width || height != camera.height)
      return fail(FaultKind::bad_input, "{}: is {} x {}: expected {} x {}, as the other pictures are", file.string(),
                  width, height, camera.width, camera.height);
    readings.push_back(watch->read(camera, photograph->encoded));
  }
  // An unchanged scene is one reading, so that neighbours in time have to be neighbours: by their names, whatever order
  // they were given in.
  std::vector<std::size_t> by_name(files.size());
  std::iota(by_name.begin(), by_name.end(), std::size_t{0});
  std::ranges::stable_sort(by_name, {}, [&](std::size_t i) { return files[i].filename(); });
  std::vector<std::vector<ContrastReading>> in_time;
  for (const auto i : by_name) in_time.push_back(readings[i]);
  auto airs = watch->estimate_all(in_time);
  VisibilitySeries found{std::move(*watch), std::vector<VisibilityReading>(files.size())};
  for (std::size_t k = 0; k < files.size(); ++k) {
    const auto i = by_name[k];
    found.pictures[i] = {files[i], std::move(readings[i]), std::move(airs[k])};
  }
  return found;
}

std::string visibility_json(const LandmarkWatch& watch, const VisibilityReading& scene, const ExtinctionComparison* sky,
                            const VisibilityCheck* check) {
  const auto& air = scene.air;
  const auto& green = air.extinction();
  const bool value = green.kind == ExtinctionKind::value, something = green.kind != ExtinctionKind::nothing;
  Json json;
  json["scene"] = scene.picture.string();
  json["visibility"] = visibility_name(green.kind);
  json["visibility_m"] = something ? Json(rounded(air.visibility_m(), 4)) : Json(nullptr);
  json["sigma_m"] = value ? Json(rounded(air.visibility_sigma_m(), 3)) : Json(nullptr);
  json["optical_range_m"] = something ? Json(rounded(air.optical_range_m(), 4)) : Json(nullptr);
  json["reason"] = green.reason;
  json["doubt"] = air.doubt;
  json["extinction_per_m"] = per_channel(air, [](const auto& e) { return e.per_m; });
  json["extinction_sigma_per_m"] = per_channel(air, [](const auto& e) { return e.sigma_per_m; });
  json["extinction_lowest_per_m"] = per_channel(air, [](const auto& e) { return e.lowest_per_m; });
  json["extinction_highest_per_m"] = per_channel(air, [](const auto& e) { return e.highest_per_m; });
  const auto& aerosol = air.aerosol;
  const bool seen = aerosol.kind == ExtinctionKind::value;
  json["aerosol_per_m"] = seen ? Json(rounded(aerosol.per_m, 4)) : Json(nullptr);
  json["aerosol_sigma_per_m"] = seen ? Json(rounded(std::sqrt(aerosol.covariance.per_m), 3)) : Json(nullptr);
  const bool coloured = seen && aerosol.exponent_told;
  json["angstrom_exponent"] = coloured ? Json(rounded(aerosol.angstrom_exponent, 3)) : Json(nullptr);
  json["angstrom_sigma"] = coloured ? Json(rounded(std::sqrt(aerosol.covariance.exponent), 2)) : Json(nullptr);
  const auto& turbidity = air.turbidity;
  json["saturation"] = air.camera.known() ? Json(rounded(air.camera.chroma, 3)) : Json(nullptr);
  json["saturation_sigma"] =
      air.camera.known() ? Json(rounded(air.camera.chroma * air.camera.log_sigma, 2)) : Json(nullptr);
  json["tone_exponent"] = air.tone.known() ? Json(rounded(air.tone.exponent, 3)) : Json(nullptr);
  json["tone_exponent_sigma"] =
      air.tone.known() ? Json(rounded(air.tone.exponent * air.tone.log_sigma, 2)) : Json(nullptr);
  json["turbidity"] = turbidity.turbidity ? Json(rounded(turbidity.turbidity->value, 4)) : Json(nullptr);
  json["turbidity_sigma"] = turbidity.turbidity ? Json(rounded(turbidity.sigma, 3)) : Json(nullptr);
  json["turbidity_reason"] = turbidity.reason;
  json["readings"] = Json::array();
  for (std::size_t i = 0; i < scene.readings.size(); ++i) {
    const auto& reading = scene.readings[i];
    const auto& landmark = watch.landmarks()[i];
    const bool left_out = std::find(green.left_out.begin(), green.left_out.end(), i) != green.left_out.end();
    Json entry{{"name", landmark.name},
               {"distance_m", landmark.distance_m},
               {"used", reading.usable && !left_out},
               {"reason", left_out ? std::string("inconsistent with the others") : reading.reason}};
    Json contrast = Json::array(), sigma = Json::array();
    for (int c = 0; reading.usable && c < 3; ++c) {
      contrast.push_back(rounded(reading.contrast[c], 4));
      sigma.push_back(rounded(reading.sigma[c], 2));
    }
    entry["contrast"] = reading.usable ? contrast : Json(nullptr);
    entry["sigma"] = reading.usable ? sigma : Json(nullptr);
    json["readings"].push_back(std::move(entry));
  }
  json["sky"] = nullptr;
  if (sky)
    json["sky"] = {{"agreement", name_of(sky->agreement)},
                   {"extinction_per_m", rounded(sky->sky_per_m, 4)},
                   {"extinction_sigma_per_m", rounded(sky->sky_sigma_per_m, 3)},
                   {"sigmas", rounded(sky->sigmas, 3)},
                   {"words", sky->message}};
  json["measured"] = nullptr;
  if (check)
    json["measured"] = {{"optical_range_m", check->measured_m},
                        {"factor", something ? Json(rounded(check->factor, 4)) : Json(nullptr)},
                        {"sigmas", value ? Json(rounded(check->sigmas, 3)) : Json(nullptr)},
                        {"holds", check->holds}};
  return text_of_json(json);
}

std::string visibility_text(const LandmarkWatch& watch, const VisibilityReading& scene,
                            const ExtinctionComparison* sky) {
  const auto& air = scene.air;
  const auto& green = air.extinction();
  std::string text = scene.picture.string() + "\n";
  if (green.kind == ExtinctionKind::nothing)
    text += fmt::format("  by landmarks     {}\n", green.reason);
  else if (green.kind == ExtinctionKind::value)
    text += fmt::format("  by landmarks     visibility {:.2f} +- {:.2f} km (optical range, 5 %: {:.2f} km)\n",
                        air.visibility_m() / 1e3, air.visibility_sigma_m() / 1e3, air.optical_range_m() / 1e3);
  else
    text +=
        fmt::format("  by landmarks     visibility {} {:.2f} km (optical range, 5 %: {:.2f} km): {}\n",
                    visibility_name(green.kind), air.visibility_m() / 1e3, air.optical_range_m() / 1e3, green.reason);
  if (!air.doubt.empty()) text += fmt::format("  doubtful         {}\n", air.doubt);
  if (green.kind == ExtinctionKind::value) {
    text +=
        fmt::format("  extinction       R {:.3f}, G {:.3f}, B {:.3f} +- {:.3f} per km\n", 1e3 * air.channels[0].per_m,
                    1e3 * green.per_m, 1e3 * air.channels[2].per_m, 1e3 * green.sigma_per_m);
    if (air.aerosol.kind == ExtinctionKind::value)
      text += fmt::format("  of its aerosol   {:.3f} +- {:.3f} per km at 550 nm, exponent {}\n",
                          1e3 * air.aerosol.per_m, 1e3 * std::sqrt(air.aerosol.covariance.per_m),
                          air.aerosol.exponent_told ? fmt::format("{:.1f} +- {:.1f}", air.aerosol.angstrom_exponent,
                                                                  std::sqrt(air.aerosol.covariance.exponent))
                                                    : "not determined: the colours are no aerosol's");
    if (air.turbidity.turbidity)
      text +=
          fmt::format("  that would be    T {:.2f} +- {:.2f}\n", air.turbidity.turbidity->value, air.turbidity.sigma);
    else
      text += fmt::format("  that would be    {}\n", air.turbidity.reason);
  }
  for (std::size_t i = 0; i < scene.readings.size(); ++i) {
    const auto& reading = scene.readings[i];
    if (!reading.usable) text += fmt::format("  not used         {}: {}\n", watch.landmarks()[i].name, reading.reason);
  }
  for (const auto i : green.left_out)
    text += fmt::format("  not used         {}: inconsistent with the others\n", watch.landmarks()[i].name);
  if (sky) text += fmt::format("  against the sky  {}\n", sky->message);
  return text;
}

}  // namespace kasumi
