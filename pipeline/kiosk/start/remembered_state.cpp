#include "pipeline/kiosk/start/remembered_state.hpp"

#include <array>
#include <cmath>

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/lasting_file.hpp"
#include "base/outside/json_depth.hpp"
#include "base/outside/json_text.hpp"
#include "base/utc_text.hpp"

namespace kasumi {

namespace {

using Json = nlohmann::json;

std::filesystem::path turbidity_file(const std::filesystem::path& folder) {
  return folder / "turbidity.json";
}

std::filesystem::path landmark_file(const std::filesystem::path& folder) {
  return folder / "landmarks.json";
}

std::string text_of(const std::optional<LandmarkBox>& box) {
  return box ? fmt::format("{},{},{},{}", box->x, box->y, box->width, box->height) : "-";
}

// A landmark with another box or distance is another landmark.
std::vector<std::string> identities_of(const std::vector<ContrastLandmark>& landmarks) {
  std::vector<std::string> all;
  for (const auto& one : landmarks)
    all.push_back(fmt::format("{} at {:.1f} m, {:.1f} m up, {} against {}, sky {}", one.name, one.distance_m,
                              one.rise_m, text_of(one.surface), text_of(one.against), text_of(one.sky)));
  return all;
}

Json json_of(const std::array<glm::dvec3, 3>& response) {
  Json all = Json::array();
  for (const auto& light : response)
    for (int c = 0; c < 3; ++c) all.push_back(std::round(1e4 * light[c]) / 1e4);
  return all;
}

// Of a landmark contrast and sigma of R, G and B; null where it could not be read. Readings are sure to three digits.
Json json_of(const KeptReadings& kept) {
  Json all = Json::array();
  for (const auto& one : kept.readings) {
    Json numbers = Json::array();
    for (const auto* of : {&one.contrast, &one.sigma})
      for (int c = 0; c < 3; ++c) numbers.push_back(std::round(1e5 * (*of)[c]) / 1e5);
    all.push_back(one.usable ? std::move(numbers) : Json(nullptr));
  }
  return {{"day", kept.day ? Json(std::round(1e3 * *kept.day) / 1e3) : Json(nullptr)}, {"readings", std::move(all)}};
}

// Empty: damaged.
std::optional<KeptReadings> kept_readings(const Json& json) {
  if (!json.is_object() || !json.contains("readings") || !json["readings"].is_array()) return std::nullopt;
  KeptReadings kept;
  if (json.contains("day") && json["day"].is_number()) kept.day = json["day"].get<double>();
  for (const auto& one : json["readings"]) {
    ContrastReading reading;
    if (one.is_array() && one.size() == 6) {
      for (std::size_t k = 0; k < 6; ++k) {
        if (!one[k].is_number()) return std::nullopt;
        (k < 3 ? reading.contrast : reading.sigma)[static_cast<int>(k % 3)] = one[k].get<double>();
      }
      const auto possible = [](double contrast, double sigma) {
        return std::abs(contrast) < 100.0 && sigma >= 0.0 && sigma < 100.0;
      };
      for (int c = 0; c < 3; ++c)
        if (!possible(reading.contrast[c], reading.sigma[c])) return std::nullopt;
      reading.usable = true;
    } else if (!one.is_null()) {
      return std::nullopt;
    }
    kept.readings.push_back(std::move(reading));
  }
  return kept;
}

Json json_of(const RememberedAir& air) {
  return {{"aod_550", air.aerosol.aod_550},
          {"sigma_aod_550", air.sigma_aod_550},
          {"angstrom_exponent", air.aerosol.angstrom_exponent},
          {"sigma_angstrom", air.sigma_angstrom},
          {"aerosol", name_of(air.aerosol.kind)},
          {"papers_sky", air.papers_sky},
          {"near_ground", air.near_ground},
          {"sigma_log_near_ground", air.sigma_log_near_ground}};
}

// Empty: damaged.
std::optional<RememberedAir> remembered_air(const Json& json, Utc utc) {
  const auto number = [&](const char* key) {
    return json.is_object() && json.contains(key) && json[key].is_number() ? json[key].get<double>() : std::nan("");
  };
  if (!json.is_object() || !json.contains("aerosol") || !json["aerosol"].is_string()) return std::nullopt;
  const auto kind = aerosol_kind_named(json["aerosol"].get<std::string>());
  if (!kind || !json.contains("papers_sky") || !json["papers_sky"].is_boolean()) return std::nullopt;
  RememberedAir air{{number("aod_550"), number("angstrom_exponent"), *kind},
                    number("sigma_aod_550"),
                    number("sigma_angstrom"),
                    json["papers_sky"].get<bool>(),
                    number("near_ground"),
                    number("sigma_log_near_ground"),
                    utc};
  const bool possible = air.aerosol.aod_550 >= 0.0 && air.aerosol.aod_550 < 10.0 &&
                        std::abs(air.aerosol.angstrom_exponent) < 5.0 && air.sigma_aod_550 >= 0.0 &&
                        air.sigma_aod_550 < 10.0 && air.sigma_angstrom >= 0.0 && air.sigma_angstrom < 10.0 &&
                        air.near_ground > 0.0 && air.near_ground < 1e3 && air.sigma_log_near_ground >= 0.0 &&
                        air.sigma_log_near_ground < 10.0;
  return possible ? std::optional(air) : std::nullopt;
}

// Between readings the state stays as it is; its time is known to a second or two.
bool of_one_reading(const TurbidityState& a, const TurbidityState& b) {
  return std::chrono::abs(a.utc - b.utc) < std::chrono::seconds(2) && a.sky_model == b.sky_model &&
         a.aerosol == b.aerosol && a.angstrom_exponent == b.angstrom_exponent && a.air.has_value() == b.air.has_value();
}

}  // namespace

TurbidityState turbidity_state(Turbidity turbidity, double sigma, Utc utc, const ModelToFit& sky) {
  if (!sky.aerosol) return {turbidity, sigma, utc, sky.model};
  return {turbidity, sigma, utc, sky.model, std::string(name_of(sky.aerosol->kind)), sky.aerosol->angstrom_exponent};
}

bool TurbidityState::belongs_to(const ModelToFit& sky) const {
  const TurbidityState now = turbidity_state(turbidity, sigma, utc, sky);
  const bool same_given = aerosol == now.aerosol && std::abs(angstrom_exponent - now.angstrom_exponent) < 1e-6;
  // An optical depth means the same whatever model found it; T alone is another quantity.
  const bool alone = sky.model == DaylightModel::preetham && !sky.every_model;
  return same_given && (air ? !alone : sky_model == now.sky_model);
}

Result<> save(const TurbidityState& state, const std::filesystem::path& folder) {
  if (const auto kept = load_turbidity_state(folder); kept && of_one_reading(*kept, state)) return {};
  Json json = {{"turbidity", state.turbidity.value},
               {"sigma", state.sigma},
               {"utc", utc_text(state.utc)},
               {"sky_model", name_of(state.sky_model)}};
  if (!state.aerosol.empty()) {
    json["aerosol"] = state.aerosol;
    json["angstrom_exponent"] = state.angstrom_exponent;
  }
  if (state.air) json["air"] = json_of(*state.air);
  return write_text_file(turbidity_file(folder), text_of_json(json, 1) + "\n");
}

Result<TurbidityState> load_turbidity_state(const std::filesystem::path& folder) {
  const auto text = read_text_file(turbidity_file(folder));
  if (!text) return fail(text.error());
  const auto json = parse_json(modest_json(*text));
  const auto number = [&](const char* key) {
    return json.is_object() && json.contains(key) && json[key].is_number() ? json[key].get<double>() : std::nan("");
  };
  const bool has_utc = json.is_object() && json.contains("utc") && json["utc"].is_string();
  const auto utc = has_utc ? parse_utc(json["utc"].get<std::string>()) : std::nullopt;
  // Older files do not name the model: it was always Preetham's.
  auto model = DaylightModel::preetham;
  if (json.is_object() && json.contains("sky_model")) {
    const auto& name = json["sky_model"];
    const auto named = name.is_string() ? daylight_model_named(name.get<std::string>()) : std::nullopt;
    model = named.value_or(DaylightModel::automatic);  // its name is always rejected below
  }
  TurbidityState state{{number("turbidity")}, number("sigma"), utc.value_or(Utc{}), model};
  if (json.is_object() && json.contains("aerosol") && json["aerosol"].is_string()) {
    state.aerosol = json["aerosol"].get<std::string>();
    state.angstrom_exponent = number("angstrom_exponent");
  }
  const bool has_air = json.is_object() && json.contains("air");
  if (has_air) state.air = remembered_air(json["air"], state.utc);
  const bool possible = utc && has_air == state.air.has_value() && model != DaylightModel::automatic &&
                        state.turbidity.value > 1.0 && state.turbidity.value <= 2.0 * kHighestTurbidity.value &&
                        state.sigma >= 0.0 && std::isfinite(state.sigma);
  if (!possible)
    return fail(
        FaultKind::bad_input,
        "{}: expected {{\"turbidity\": T > 1, \"sigma\": >= 0, \"utc\": \"...Z\", \"sky_model\": \"preetham\" or "
        "\"dome\", ...}}",
        turbidity_file(folder).string());
  return state;
}

Result<> save(const LandmarkWatch& watch, const std::filesystem::path& folder) {
  Json json = {{"landmarks", identities_of(watch.landmarks())},
               {"response", json_of(watch.response())},
               {"kept", Json::array()}};
  for (const auto& kept : watch.kept()) json["kept"].push_back(json_of(kept));
  if (auto written = update_text_file(landmark_file(folder), text_of_json(json) + "\n"); !written)
    return fail(written.error());
  return {};
}

Result<bool> resume(LandmarkWatch& watch, const std::filesystem::path& folder) {
  const auto file = landmark_file(folder);
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return false;
  const auto text = read_text_file(file);
  if (!text) return fail(text.error());
  const auto json = parse_json(modest_json(*text));
  const auto damaged = [&] {
    return fail(FaultKind::bad_input, "{}: damaged; learning the landmarks' contrasts again", file.string());
  };
  if (!json.is_object() || !json.contains("landmarks")) return damaged();
  if (json["landmarks"] != Json(identities_of(watch.landmarks())))
    return fail(FaultKind::bad_input, "{}: saved for other landmarks than configured; learning their contrasts again",
                file.string());
  if (json.contains("response") && json["response"] != json_of(watch.response()))  // older files do not have it
    return fail(
        FaultKind::bad_input,
        "{}: saved before the scene camera's response was calibrated anew; learning the landmarks' contrasts again",
        file.string());
  if (!json.contains("kept") || !json["kept"].is_array()) return damaged();
  std::vector<KeptReadings> all;
  for (const auto& one : json["kept"]) {
    auto kept = kept_readings(one);
    if (!kept) return damaged();
    all.push_back(std::move(*kept));
  }
  if (!watch.resume(std::move(all))) return damaged();
  return true;
}

}  // namespace kasumi
