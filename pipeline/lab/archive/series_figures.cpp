#include "pipeline/lab/archive/series_figures.hpp"

#include <algorithm>
#include <numeric>

#include <nlohmann/json.hpp>

#include "base/utc_text.hpp"
#include "pipeline/lab/archive/archive_record.hpp"

namespace kasumi {
namespace {

constexpr double kHorizon_deg = 90.0;

std::optional<double> figure_at(const nlohmann::json& record, const char* pointer) {
  const nlohmann::json::json_pointer place(pointer);
  return record.contains(place) && record[place].is_number() ? std::optional(record[place].get<double>())
                                                             : std::nullopt;
}
std::string words_at(const nlohmann::json& record, const char* key) {
  return record.contains(key) && record[key].is_string() ? record[key].get<std::string>() : std::string();
}

std::optional<double> middle_of(std::vector<float> values) {
  if (values.empty()) return std::nullopt;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return static_cast<double>(*middle);
}

}  // namespace

std::string_view name_of(EstimateFate fate) {
  switch (fate) {
    case EstimateFate::air_known: return "air known";
    case EstimateFate::cloudy: return "cloudy";
    case EstimateFate::sun_too_low: return "sun too low";
    case EstimateFate::night: return "night";
    case EstimateFate::other: return "refused for other reasons";
  }
  return "";
}

EstimateFate fate_of(const nlohmann::json& record) {
  const auto verdict = words_at(record, "verdict"), sky = words_at(record, "sky");
  if (verdict == "night" || figure_at(record, "/sun_zenith_deg").value_or(0.0) > kHorizon_deg)
    return EstimateFate::night;
  if (words_at(record, "refused").empty()) return EstimateFate::air_known;
  if (verdict == "sun too low") return EstimateFate::sun_too_low;
  return verdict == "overcast" || sky == "overcast" || sky == "broken" ? EstimateFate::cloudy : EstimateFate::other;
}

std::size_t MonthlyTally::pictures() const {
  return std::accumulate(fates_.begin(), fates_.end(), std::size_t{0});
}
std::optional<double> MonthlyTally::sun_off_deg() const {
  return middle_of(suns_off_deg_);
}
std::optional<double> MonthlyTally::radius_px() const {
  return middle_of(radii_px_);
}

void SeriesFigures::add(const nlohmann::json& record) {
  const auto utc = parse_utc(words_at(record, "utc"));
  if (!utc || words_at(record, "refused") == kExposureOfStack) return;
  auto& month = months_[month_of(std::chrono::floor<std::chrono::days>(*utc + ahead_))];
  const auto fate = fate_of(record);
  month.add(fate);
  if (fate == EstimateFate::night) return;
  if (const auto off = figure_at(record, "/sun_seen/disagreement_deg")) month.add_sun_off_deg(*off);
  if (const auto radius = figure_at(record, "/circle/2")) month.add_radius_px(*radius);
}

int month_of(std::chrono::sys_days day) {
  const std::chrono::year_month_day date{day};
  return 12 * static_cast<int>(date.year()) + static_cast<int>(static_cast<unsigned>(date.month())) - 1;
}

std::vector<MonthlyValue> monthly_aod(const ArchiveFigures& figures) {
  constexpr std::size_t kLeastDays = 3;
  std::map<int, std::vector<double>> days;
  for (const auto& [day, cell] : figures.days())
    if (const auto aod = cell.aod()) days[month_of(day)].push_back(aod->median);
  std::vector<MonthlyValue> months;
  for (const auto& [month, values] : days)
    if (values.size() >= kLeastDays)
      months.push_back(
          {month, std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size())});
  return months;
}

}  // namespace kasumi
