#include <nlohmann/json.hpp>

#include "capture/utc_text.hpp"
#include "pipeline/drift.hpp"

namespace kasumi {

std::string drift_json(const DriftReport& report) {
  const auto or_null = [](const std::optional<double>& value) {
    return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
  };
  const auto date = [](Utc utc) { return utc_text(std::chrono::floor<std::chrono::seconds>(utc)); };
  nlohmann::ordered_json json;
  json["well"] = report.well();
  json["utc"] = date(report.checked);
  json["reference_utc"] = date(report.reference);
  json["summary"] = drift_summary(report);
  json["findings"] = nlohmann::ordered_json::array();
  for (const auto& finding : report.findings)
    json["findings"].push_back({{"camera", finding.camera},
                                {"what", finding.what},
                                {"state", name_of(finding.state)},
                                {"words", finding.words},
                                {"value", or_null(finding.value)},
                                {"sigma", or_null(finding.sigma)},
                                {"alarm", or_null(finding.alarm)},
                                {"unit", finding.unit}});
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace kasumi
