#include "base/utc_text.hpp"

#include <fmt/format.h>

namespace kasumi {

namespace {

// Reads a fixed number of digits at a fixed position.
std::optional<unsigned> digits(std::string_view text, std::size_t at, std::size_t count) {
  if (text.size() < at + count) return std::nullopt;
  unsigned value = 0;
  for (const char c : text.substr(at, count)) {
    if (c < '0' || c > '9') return std::nullopt;
    value = 10 * value + static_cast<unsigned>(c - '0');
  }
  return value;
}

}  // namespace

std::string utc_text(Utc utc) {
  const auto day = std::chrono::floor<std::chrono::days>(utc);
  const std::chrono::year_month_day date{day};
  const std::chrono::hh_mm_ss time{utc - day};
  auto text = fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}", static_cast<int>(date.year()),
                          static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()), time.hours().count(),
                          time.minutes().count(), time.seconds().count());
  const auto fraction = time.subseconds().count();
  if (fraction % 1'000'000 == 0 && fraction != 0)
    text += fmt::format(".{:03}", fraction / 1'000'000);
  else if (fraction % 1'000 == 0 && fraction != 0)
    text += fmt::format(".{:06}", fraction / 1'000);
  else if (fraction != 0)
    text += fmt::format(".{:09}", fraction);
  return text + "Z";
}

std::optional<Utc> parse_utc(std::string_view text) {
  constexpr std::string_view kForm = "0000-00-00T00:00:00";
  if (text.size() <= kForm.size() || text.back() != 'Z') return std::nullopt;
  for (std::size_t i = 0; i < kForm.size(); ++i)
    if (kForm[i] != '0' && text[i] != kForm[i]) return std::nullopt;
  const auto year = digits(text, 0, 4), month = digits(text, 5, 2), day = digits(text, 8, 2);
  const auto hour = digits(text, 11, 2), minute = digits(text, 14, 2), second = digits(text, 17, 2);
  if (!year || !month || !day || !hour || !minute || !second) return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year{static_cast<int>(*year)}, std::chrono::month{*month},
                                         std::chrono::day{*day}};
  // Nanoseconds since 1970 fill 64 bits in the year 2262.
  if (!date.ok() || *year < 1970 || *year > 2261 || *hour > 23 || *minute > 59 || *second > 59) return std::nullopt;

  std::uint64_t nanoseconds = 0;
  auto decimals = text.substr(kForm.size());
  decimals.remove_suffix(1);
  if (!decimals.empty()) {
    if (decimals.front() != '.' || decimals.size() < 2 || decimals.size() > 10) return std::nullopt;
    const auto fraction = digits(decimals, 1, decimals.size() - 1);
    if (!fraction) return std::nullopt;
    nanoseconds = *fraction;
    for (std::size_t i = decimals.size(); i < 10; ++i) nanoseconds *= 10;
  }
  return std::chrono::sys_days{date} + std::chrono::hours{*hour} + std::chrono::minutes{*minute} +
         std::chrono::seconds{*second} + std::chrono::nanoseconds{nanoseconds};
}

}  // namespace kasumi
