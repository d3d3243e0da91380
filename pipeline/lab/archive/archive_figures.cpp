#include "pipeline/lab/archive/archive_figures.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

#include <nlohmann/json.hpp>

#include "base/utc_text.hpp"
#include "pipeline/lab/archive/archive_record.hpp"

namespace kasumi {
namespace {

constexpr double kBelowHorizon_deg = 90.0;

std::optional<double> number_in(const nlohmann::json& record, const char* key) {
  const auto found = record.find(key);
  return found != record.end() && found->is_number() ? std::optional(found->get<double>()) : std::nullopt;
}
std::string text_in(const nlohmann::json& record, const char* key) {
  const auto found = record.find(key);
  return found != record.end() && found->is_string() ? found->get<std::string>() : std::string();
}

// Reasons that differ in their numbers are one.
std::string without_numbers(const std::string& reason) {
  std::string text;
  for (const char c : reason) {
    if (std::isdigit(static_cast<unsigned char>(c)) || (c == '.' && text.ends_with("..."))) {
      if (!text.ends_with("...")) text += "...";
    } else {
      text += c;
    }
  }
  return text;
}

}  // namespace

void Cell::add(const Cell& other) {
  aods_.insert(aods_.end(), other.aods_.begin(), other.aods_.end());
  cloud_ += other.cloud_;
  clouds_ += other.clouds_;
  pictures_ += other.pictures_;
}

std::optional<Spread> Cell::aod() const {
  if (aods_.empty()) return std::nullopt;
  auto sorted = aods_;
  std::ranges::sort(sorted);
  const auto at = [&](double share) {
    return static_cast<double>(sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1) + 0.5)]);
  };
  return Spread{at(0.16), at(0.5), at(0.84)};
}

std::optional<double> Cell::cloud() const {
  return clouds_ > 0 ? std::optional(cloud_ / static_cast<double>(clouds_)) : std::nullopt;
}

void ArchiveFigures::add(const nlohmann::json& record) {
  ++pictures_;
  auto refused = text_in(record, "refused");
  if (refused == kExposureOfStack) {
    ++exposures_;
    return;
  }
  if (refused.empty() && number_in(record, "sun_zenith_deg").value_or(0.0) > kBelowHorizon_deg) {
    refused = "night";
    ++nights_;
  }
  const auto aod = refused.empty() ? number_in(record, "aod_550") : std::nullopt;
  const auto cloud = number_in(record, "cloud_fraction");
  if (refused.empty()) {
    ++usable_;
    const auto zenith = number_in(record, "sun_zenith_deg"), azimuth = number_in(record, "sun_azimuth_deg");
    if (zenith && azimuth) {
      const double around = std::fmod(*azimuth + 360.0, 360.0) / 15.0, height = (kBelowHorizon_deg - *zenith) / 10.0;
      ++suns_[static_cast<std::size_t>(std::clamp(height, 0.0, 8.0))]
             [static_cast<std::size_t>(std::clamp(around, 0.0, 23.0))];
    }
  } else
    ++refusals_[without_numbers(refused)];
  const auto utc = parse_utc(text_in(record, "utc"));
  if (!utc) {
    ++timeless_;
    return;
  }
  first_ = std::min(first_.value_or(*utc), *utc);
  last_ = std::max(last_.value_or(*utc), *utc);
  const auto wall = *utc + ahead_;
  const auto day = std::chrono::floor<std::chrono::days>(wall);
  const auto month = static_cast<unsigned>(std::chrono::year_month_day(day).month()) - 1;
  const auto hour = std::chrono::floor<std::chrono::hours>(wall - day).count();
  for (Cell* cell : {&days_[day], &hours_[month][static_cast<std::size_t>(hour)]}) {
    cell->add_picture();
    if (aod) cell->add_aod(*aod);
    if (cloud) cell->add_cloud(*cloud);
  }
}

Cell ArchiveFigures::month(std::size_t month) const {
  Cell all;
  for (const auto& hour : hours_[month]) all.add(hour);
  return all;
}

std::vector<std::pair<std::string, std::size_t>> ArchiveFigures::refusals() const {
  std::vector<std::pair<std::string, std::size_t>> sorted(refusals_.begin(), refusals_.end());
  std::ranges::stable_sort(sorted, std::ranges::greater{}, [](const auto& refusal) { return refusal.second; });
  return sorted;
}

}  // namespace kasumi
