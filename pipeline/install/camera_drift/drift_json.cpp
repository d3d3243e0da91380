#include "pipeline/install/camera_drift/drift_json.hpp"

#include <nlohmann/json.hpp>

#include "base/outside/json_text.hpp"
#include "base/utc_text.hpp"

namespace kasumi {

nlohmann::ordered_json findings_json(const DriftReport& report) {
  const auto or_null = [](const std::optional<double>& value) {
    return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
  };
  auto json = nlohmann::ordered_json::array();
  for (const auto& finding : report.findings)
    json.push_back({{"camera", finding.camera},
                    {"what", finding.what},
                    {"state", name_of(finding.state)},
                    {"words", finding.message},
                    {"value", or_null(finding.value)},
                    {"sigma", or_null(finding.sigma)},
                    {"alarm", or_null(finding.alarm)},
                    {"unit", finding.unit}});
  return json;
}

std::string drift_json(const DriftReport& report) {
  const auto date = [](Utc utc) { return utc_text(std::chrono::floor<std::chrono::seconds>(utc)); };
  nlohmann::ordered_json json;
  json["well"] = report.steady();
  json["utc"] = date(report.checked);
  json["reference_utc"] = date(report.reference);
  json["summary"] = drift_summary(report);
  json["findings"] = findings_json(report);
  return text_of_json(json, 2) + "\n";
}

}  // namespace kasumi
