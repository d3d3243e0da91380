#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/outside/json_text.hpp"
#include "base/utc_text.hpp"
#include "pipeline/kiosk/doctor/checks.hpp"

namespace kasumi {
namespace {

constexpr double kBelievable_255 = 8.0;  // median: visitors see more beside the real buildings

}  // namespace

void check_proof(const std::filesystem::path& state, Utc now, Findings& findings) {
  const auto file = state / "proof.json";
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return;  // most kiosks have none
  const auto text = read_text_file(file);
  const auto json = text ? parse_json(*text) : nlohmann::json();
  const auto number = [&](const char* key) {
    return json.is_object() && json.contains(key) && json[key].is_number() ? std::optional(json[key].get<double>())
                                                                           : std::nullopt;
  };
  const auto middle = number("error_median_255"), most = number("error_p95_255"), none = number("no_air_median_255");
  const auto made = json.is_object() && json.contains("made_utc") && json["made_utc"].is_string()
                        ? parse_utc(json["made_utc"].get<std::string>())
                        : std::nullopt;
  if (!middle || !most || !none || !made || !json.contains("part") || !json["part"].is_string()) {
    findings.warn("proof", file.string() + " cannot be read", "kasumi prove ... --state " + state.string());
    return;
  }
  const double days = to_seconds(now - *made) / 86400.0;
  const auto found =
      fmt::format("{:.0f} days ago {} was drawn {:.1f} of 255 off in the median, {:.1f} at 95 % (without air {:.1f})",
                  days, json["part"].get<std::string>(), *middle, *most, *none);
  auto& finding = *middle > kBelievable_255
                      ? findings.warn("proof", found, "landmarks' distances, their regions, the camera's calibration?")
                      : findings.good("proof", found);
  finding.values = {{"days", days}, {"error_median_255", *middle}, {"error_p95_255", *most}};
}

}  // namespace kasumi
