// Opening hours in local time.
#pragma once

#include <array>
#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "base/clock.hpp"
#include "base/result.hpp"

namespace kasumi {

// From one time of day to another, in minutes after midnight; beyond 24 h it ends on the next day.
struct OpenSpan {
  std::chrono::minutes from{};
  std::chrono::minutes until{};
  friend bool operator==(const OpenSpan&, const OpenSpan&) = default;
};
using DayHours = std::vector<OpenSpan>;  // empty: closed
inline const DayHours kAllDay{{std::chrono::hours(0), std::chrono::hours(24)}};

// "09:00-17:30", "09:00-12:00, 13:30-17:30", "18:00-01:00" (past midnight), "closed". Error: bad_input.
Result<DayHours> parse_hours(std::string_view text);

// Different hours from one date to another, both included.
struct DatedHours {
  std::chrono::year_month_day first, last;
  DayHours hours;
  friend bool operator==(const DatedHours&, const DatedHours&) = default;
};

// "2026-12-24 09:00-12:00; 2026-12-25..2027-01-02 closed": separated by semicolons or line breaks. Error: bad_input.
Result<std::vector<DatedHours>> parse_exceptions(std::string_view text);

// Dates of every year, both included; from a later to an earlier one it goes on past the year's end.
struct YearlyDates {
  std::chrono::month_day first, last;
  bool includes(std::chrono::year_month_day date) const;
  friend bool operator==(const YearlyDates&, const YearlyDates&) = default;
};
// "03-01..05-31", "12-24", "12-01..02-29, 07-01..07-31": month and day. Error: bad_input.
Result<std::vector<YearlyDates>> parse_yearly(std::string_view text);

struct OpeningHours {
  std::string time_zone;  // "Europe/Zurich"; empty: UTC
  std::array<DayHours, 7> week{kAllDay, kAllDay, kAllDay, kAllDay, kAllDay, kAllDay, kAllDay};  // Sunday first
  std::vector<DatedHours> exceptions;  // the last one that matches applies

  // Follows the zone's changes between summer and winter time. An unknown zone counts as UTC.
  bool is_open(Utc now) const;
  // Or opens within that time: what takes a while to wake is woken before the doors open.
  bool is_awake(Utc now, Duration wake_before) const;
  bool is_always_open() const { return exceptions.empty() && week == OpeningHours{}.week; }
  friend bool operator==(const OpeningHours&, const OpeningHours&) = default;
};

// By the wall clock there. An unknown zone counts as UTC.
std::chrono::local_time<Duration> local_time(const std::string& time_zone, Utc now);
// Whether the machine's tzdata has a time zone of that name.
bool is_time_zone(const std::string& name);
// The machine's own, as `timedatectl` shows it. Error: unsupported (it has no named zone).
Result<std::string> machine_time_zone();

}  // namespace kasumi
