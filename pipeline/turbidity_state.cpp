#include "pipeline/turbidity_state.hpp"

#include <cmath>

#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "capture/utc_text.hpp"

namespace kasumi {

namespace {

std::filesystem::path file_in(const std::filesystem::path& folder) {
  return folder / "turbidity.json";
}

}  // namespace

Result<> save(const TurbidityState& state, const std::filesystem::path& folder) {
  const nlohmann::json json = {{"turbidity", state.turbidity.value},
                               {"sigma", state.sigma},
                               {"utc", utc_text(state.utc)},
                               {"sky_model", name_of(state.sky_model)}};
  return write_text_file(file_in(folder), json.dump(1) + "\n");
}

Result<TurbidityState> load_turbidity_state(const std::filesystem::path& folder) {
  const auto text = read_text_file(file_in(folder));
  if (!text) return fail(FaultKind::bad_input, "{}", text.error().message);
  const auto json = nlohmann::json::parse(*text, nullptr, false);
  const auto number = [&](const char* key) {
    return json.is_object() && json.contains(key) && json[key].is_number() ? json[key].get<double>() : std::nan("");
  };
  const bool has_utc = json.is_object() && json.contains("utc") && json["utc"].is_string();
  const auto utc = has_utc ? parse_utc(json["utc"].get<std::string>()) : std::nullopt;
  // Whose T it is was not told while all were Preetham's.
  auto model = SiteSkyModel::preetham;
  if (json.is_object() && json.contains("sky_model")) {
    const auto& name = json["sky_model"];
    const auto named = name.is_string() ? site_sky_model_named(name.get<std::string>()) : std::nullopt;
    model = named.value_or(SiteSkyModel::automatic);  // no name is its own
  }
  const TurbidityState state{{number("turbidity")}, number("sigma"), utc.value_or(Utc{}), model};
  const bool possible = utc && model != SiteSkyModel::automatic && state.turbidity.value > 1.0 &&
                        state.turbidity.value <= 2.0 * kHighestTurbidity.value && state.sigma >= 0.0 &&
                        std::isfinite(state.sigma);
  if (!possible)
    return fail(
        FaultKind::bad_input,
        "{}: expected {{\"turbidity\": T > 1, \"sigma\": >= 0, \"utc\": \"...Z\", \"sky_model\": \"preetham\" or "
        "\"dome\"}}",
        file_in(folder).string());
  return state;
}

}  // namespace kasumi
