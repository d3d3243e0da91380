// An archive over years, by month: its trend, how its weather left the air unknown, and whether its camera drifted.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <map>
#include <optional>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "pipeline/lab/archive/archive_figures.hpp"
#include "pipeline/lab/archive/trend.hpp"

namespace kasumi {

// What became of a picture.
enum class EstimateFate { air_known, cloudy, sun_too_low, night, other };
constexpr std::size_t kSkyFates = 5;
std::string_view name_of(EstimateFate fate);
EstimateFate fate_of(const nlohmann::json& record);

class MonthlyTally {
 public:
  void add(EstimateFate fate) { ++fates_[static_cast<std::size_t>(fate)]; }
  // Where the sun was seen, from where time, place and camera put it; and the radius of the image circle.
  void add_sun_off_deg(double value) { suns_off_deg_.push_back(static_cast<float>(value)); }
  void add_radius_px(double value) { radii_px_.push_back(static_cast<float>(value)); }
  std::size_t count(EstimateFate fate) const { return fates_[static_cast<std::size_t>(fate)]; }
  std::size_t pictures() const;
  std::optional<double> sun_off_deg() const;  // median
  std::optional<double> radius_px() const;

 private:
  std::array<std::size_t, kSkyFates> fates_{};
  std::vector<float> suns_off_deg_, radii_px_;
};

class SeriesFigures {
 public:
  explicit SeriesFigures(std::chrono::minutes ahead) : ahead_(ahead) {}
  void add(const nlohmann::json& record);
  const std::map<int, MonthlyTally>& months() const { return months_; }  // by year * 12 + month from 0

 private:
  std::chrono::minutes ahead_;
  std::map<int, MonthlyTally> months_;
};

int month_of(std::chrono::sys_days day);  // year * 12 + month from 0

// Means of the days' medians, of months with at least three days.
std::vector<MonthlyValue> monthly_aod(const ArchiveFigures& figures);

}  // namespace kasumi
