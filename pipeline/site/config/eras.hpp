// What is shown when: the building of spring, or that of the morning.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/table/config_table.hpp"
#include "pipeline/site/config/opening_hours.hpp"

namespace kasumi {

struct Era {
  std::string name;
  std::vector<YearlyDates> dates;  // empty: all the year
  DayHours hours = kAllDay;        // of those days; past midnight they belong to the day on which they begin
  bool otherwise = false;          // neither dates nor hours: whenever no other era is shown
  bool visitors_only = false;      // shown only where a visitor chooses it
  // Instead of [object]'s and [still]'s; empty: as there.
  std::optional<std::filesystem::path> model;
  std::optional<std::string> scene;
  std::optional<std::filesystem::path> picture;
  std::optional<std::string> caption;
  bool includes(std::chrono::year_month_day day) const;
};

// [[era]]: name, dates, hours, visitors_only, model, scene, picture, caption. Problems, all at once: eras of the same name, two at the
// same time, and times at which the kiosk may be open and none is shown.
std::vector<Era> read_eras(const ConfigTable& root, const OpeningHours& opening);

// Which of them is shown, by the wall clock of that zone; while none is, the next to come, so that it is there in time.
// Empty: there are no eras.
std::optional<std::size_t> era_at(const std::vector<Era>& eras, const std::string& time_zone, Utc now);

}  // namespace kasumi
