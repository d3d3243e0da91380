#include "pipeline/site/config/opening_hours.hpp"

#include <algorithm>
#include <charconv>
#include <exception>
#include <optional>

// The calendar is the standard library's; time zones come from the date library until g++ 14 has them.
#include <date/tz.h>

namespace kasumi {

namespace {

using namespace std::chrono_literals;
using std::chrono::days;
using std::chrono::minutes;

constexpr std::string_view kBlanks = " \t\r\n";

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::vector<std::string_view> split(std::string_view text, std::string_view separators) {
  std::vector<std::string_view> pieces;
  while (true) {
    const auto at = text.find_first_of(separators);
    pieces.push_back(trimmed(text.substr(0, at)));
    if (at == std::string_view::npos) return pieces;
    text.remove_prefix(at + 1);
  }
}

// The text consists of exactly that many digits.
std::optional<int> number(std::string_view text, std::size_t digits) {
  int value = 0;
  if (text.size() != digits || !std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; }))
    return std::nullopt;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

// "09:30"; 24:00 is midnight at the day's end
std::optional<minutes> time_of_day(std::string_view text) {
  if (text.size() != 5 || text[2] != ':') return std::nullopt;
  const auto hour = number(text.substr(0, 2), 2), minute = number(text.substr(3), 2);
  if (!hour || !minute || *minute > 59) return std::nullopt;
  const auto time = *hour * 60min + *minute * 1min;
  return time <= 24h ? std::optional(time) : std::nullopt;
}

// "2026-12-24"
std::optional<std::chrono::year_month_day> date_of(std::string_view text) {
  if (text.size() != 10 || text[4] != '-' || text[7] != '-') return std::nullopt;
  const auto year = number(text.substr(0, 4), 4), month = number(text.substr(5, 2), 2), day = number(text.substr(8), 2);
  if (!year || !month || !day) return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year(*year), std::chrono::month(static_cast<unsigned>(*month)),
                                         std::chrono::day(static_cast<unsigned>(*day))};
  return date.ok() ? std::optional(date) : std::nullopt;
}

// "12-24"
std::optional<std::chrono::month_day> day_of_year(std::string_view text) {
  if (text.size() != 5 || text[2] != '-') return std::nullopt;
  const auto month = number(text.substr(0, 2), 2), day = number(text.substr(3), 2);
  if (!month || !day) return std::nullopt;
  const auto date = std::chrono::month(static_cast<unsigned>(*month)) / std::chrono::day(static_cast<unsigned>(*day));
  return date.ok() ? std::optional(date) : std::nullopt;
}

const DayHours& hours_of(const OpeningHours& hours, std::chrono::local_days day) {
  const std::chrono::year_month_day date(day);
  const auto fits = [&](const DatedHours& exception) { return exception.first <= date && date <= exception.last; };
  const auto exception = std::find_if(hours.exceptions.rbegin(), hours.exceptions.rend(), fits);
  if (exception != hours.exceptions.rend()) return exception->hours;
  return hours.week[std::chrono::weekday(day).c_encoding()];
}

}  // namespace

Result<DayHours> parse_hours(std::string_view text) {
  const auto wrong = [&] {
    return fail(FaultKind::bad_input, R"(hours like "09:00-17:30", "09:00-12:00, 13:30-17:30" or "closed", not "{}")",
                trimmed(text));
  };
  if (trimmed(text) == "closed") return DayHours{};
  DayHours hours;
  for (const auto piece : split(text, ",")) {
    const auto ends = split(piece, "-");
    if (ends.size() != 2) return wrong();
    const auto from = time_of_day(ends[0]), until = time_of_day(ends[1]);
    if (!from || !until || *from == *until || *from == 24h) return wrong();
    hours.push_back({*from, *until > *from ? *until : *until + 24h});
  }
  return hours;
}

Result<std::vector<DatedHours>> parse_exceptions(std::string_view text) {
  std::vector<DatedHours> exceptions;
  for (const auto piece : split(text, ";\n")) {
    if (piece.empty()) continue;
    const auto gap = std::min(piece.find_first_of(kBlanks), piece.size());
    const auto day = piece.substr(0, gap);
    const auto dots = day.find("..");
    const auto first = date_of(day.substr(0, dots));
    const auto last = dots == std::string_view::npos ? first : date_of(day.substr(dots + 2));
    if (!first || !last || *last < *first)
      return fail(FaultKind::bad_input, R"(a date like "2026-12-24" or "2026-12-25..2027-01-02" first, in "{}")",
                  piece);
    const auto hours = parse_hours(piece.substr(gap));
    if (!hours) return fail(hours.error());
    exceptions.push_back({*first, *last, *hours});
  }
  return exceptions;
}

bool YearlyDates::includes(std::chrono::year_month_day date) const {
  const auto day = date.month() / date.day();
  return first <= last ? first <= day && day <= last : first <= day || day <= last;
}

Result<std::vector<YearlyDates>> parse_yearly(std::string_view text) {
  std::vector<YearlyDates> found;
  for (const auto piece : split(text, ",")) {
    const auto dots = piece.find("..");
    const auto first = day_of_year(trimmed(piece.substr(0, dots)));
    const auto last = dots == std::string_view::npos ? first : day_of_year(trimmed(piece.substr(dots + 2)));
    if (!first || !last)
      return fail(FaultKind::bad_input,
                  R"(months and days like "03-01..05-31" or "12-24", separated by commas, not "{}")", trimmed(text));
    found.push_back({*first, *last});
  }
  return found;
}

std::chrono::local_time<Duration> local_time(const std::string& zone, Utc now) {
  const auto since = now.time_since_epoch();
  try {
    if (!zone.empty())
      return std::chrono::local_time<Duration>(
          date::locate_zone(zone)->to_local(date::sys_time<Duration>(since)).time_since_epoch());
  } catch (const std::exception&) {  // removed since the configuration was read: UTC
  }
  return std::chrono::local_time<Duration>(since);
}

bool OpeningHours::is_open(Utc now) const {
  const auto local = local_time(time_zone, now);
  const auto today = std::chrono::floor<days>(local);
  // Yesterday's hours may extend past midnight.
  for (const auto day : {today, today - days(1)})
    for (const auto& span : hours_of(*this, day))
      if (local - day >= span.from && local - day < span.until) return true;
  return false;
}

// Minutes are the finest that hours are given in, and a span may be as short.
bool OpeningHours::is_awake(Utc now, Duration wake_before) const {
  for (auto ahead = Duration::zero(); ahead < wake_before; ahead += minutes(1))
    if (is_open(now + ahead)) return true;
  return is_open(now + wake_before) || is_open(now);
}

bool is_time_zone(const std::string& name) {
  try {
    return date::locate_zone(name) != nullptr;
  } catch (const std::exception&) {
    return false;
  }
}

Result<std::string> machine_time_zone() {
  try {
    return date::current_zone()->name();
  } catch (const std::exception& problem) {
    return fail(FaultKind::unsupported, "{}", problem.what());
  }
}

}  // namespace kasumi
