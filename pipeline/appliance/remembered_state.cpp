#include "pipeline/appliance/remembered_state.hpp"

#include <cmath>

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "capture/utc_text.hpp"

namespace kasumi {

namespace {

using Json = nlohmann::json;

std::filesystem::path turbidity_file(const std::filesystem::path& folder) {
  return folder / "turbidity.json";
}

std::filesystem::path landmark_file(const std::filesystem::path& folder) {
  return folder / "landmarks.json";
}

std::string text_of(const std::optional<PictureBox>& box) {
  return box ? fmt::format("{},{},{},{}", box->x, box->y, box->width, box->height) : "-";
}

// A landmark with another box or distance is another landmark.
std::vector<std::string> identities_of(const std::vector<ContrastLandmark>& landmarks) {
  std::vector<std::string> all;
  for (const auto& one : landmarks)
    all.push_back(fmt::format("{} at {:.1f} m, {:.1f} m up, {} against {}, sky {}, {} +- {}", one.name, one.distance_m,
                              one.rise_m, text_of(one.surface), text_of(one.against), text_of(one.sky), one.contrast,
                              one.contrast_sigma));
  return all;
}

std::vector<double> numbers(const Json& json, const char* key) {
  std::vector<double> values;
  if (!json.is_object() || !json.contains(key) || !json[key].is_array()) return values;
  for (const auto& value : json[key])
    if (value.is_number()) values.push_back(value.get<double>());
  return values;
}

}  // namespace

TurbidityState turbidity_state(Turbidity turbidity, double sigma, Utc utc, const SkyToFit& sky) {
  if (!sky.aerosol) return {turbidity, sigma, utc, sky.model};
  return {turbidity, sigma, utc, sky.model, std::string(name_of(sky.aerosol->kind)), sky.aerosol->angstrom_exponent};
}

bool TurbidityState::belongs_to(const SkyToFit& sky) const {
  const TurbidityState now = turbidity_state(turbidity, sigma, utc, sky);
  return sky_model == now.sky_model && aerosol == now.aerosol &&
         std::abs(angstrom_exponent - now.angstrom_exponent) < 1e-6;
}

Result<> save(const TurbidityState& state, const std::filesystem::path& folder) {
  Json json = {{"turbidity", state.turbidity.value},
               {"sigma", state.sigma},
               {"utc", utc_text(state.utc)},
               {"sky_model", name_of(state.sky_model)}};
  if (!state.aerosol.empty()) {
    json["aerosol"] = state.aerosol;
    json["angstrom_exponent"] = state.angstrom_exponent;
  }
  return write_text_file(turbidity_file(folder), json.dump(1) + "\n");
}

Result<TurbidityState> load_turbidity_state(const std::filesystem::path& folder) {
  const auto text = read_text_file(turbidity_file(folder));
  if (!text) return fail(FaultKind::bad_input, "{}", text.error().message);
  const auto json = Json::parse(*text, nullptr, false);
  const auto number = [&](const char* key) {
    return json.is_object() && json.contains(key) && json[key].is_number() ? json[key].get<double>() : std::nan("");
  };
  const bool has_utc = json.is_object() && json.contains("utc") && json["utc"].is_string();
  const auto utc = has_utc ? parse_utc(json["utc"].get<std::string>()) : std::nullopt;
  // Older files do not name the model: it was always Preetham's.
  auto model = SiteSkyModel::preetham;
  if (json.is_object() && json.contains("sky_model")) {
    const auto& name = json["sky_model"];
    const auto named = name.is_string() ? site_sky_model_named(name.get<std::string>()) : std::nullopt;
    model = named.value_or(SiteSkyModel::automatic);  // its name is always rejected below
  }
  TurbidityState state{{number("turbidity")}, number("sigma"), utc.value_or(Utc{}), model};
  if (json.is_object() && json.contains("aerosol") && json["aerosol"].is_string()) {
    state.aerosol = json["aerosol"].get<std::string>();
    state.angstrom_exponent = number("angstrom_exponent");
  }
  const bool possible = utc && model != SiteSkyModel::automatic && state.turbidity.value > 1.0 &&
                        state.turbidity.value <= 2.0 * kHighestTurbidity.value && state.sigma >= 0.0 &&
                        std::isfinite(state.sigma);
  if (!possible)
    return fail(
        FaultKind::bad_input,
        "{}: expected {{\"turbidity\": T > 1, \"sigma\": >= 0, \"utc\": \"...Z\", \"sky_model\": \"preetham\" or "
        "\"dome\"}}",
        turbidity_file(folder).string());
  return state;
}

Result<> save(const LandmarkWatch& watch, const std::filesystem::path& folder) {
  Json json = {{"landmarks", identities_of(watch.landmarks())}};
  for (const auto& channel : watch.learnt())
    json["channels"].push_back({{"contrasts", channel.mean}, {"covariance", channel.covariance}});
  return write_text_file(landmark_file(folder), json.dump(1) + "\n");
}

Result<bool> resume(LandmarkWatch& watch, const std::filesystem::path& folder) {
  const auto file = landmark_file(folder);
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return false;
  const auto text = read_text_file(file);
  if (!text) return fail(FaultKind::bad_input, "{}", text.error().message);
  const auto json = Json::parse(*text, nullptr, false);
  if (!json.is_object() || json.value("landmarks", Json()) != Json(identities_of(watch.landmarks())))
    return fail(FaultKind::bad_input, "{}: saved for other landmarks than configured; learning their contrasts again",
                file.string());
  std::vector<LearntContrasts> learnt;
  for (const auto& channel : json.value("channels", Json::array()))
    learnt.push_back({numbers(channel, "contrasts"), numbers(channel, "covariance")});
  if (!watch.resume(learnt))
    return fail(FaultKind::bad_input, "{}: damaged; learning the landmarks' contrasts again", file.string());
  return true;
}

}  // namespace kasumi
