#include "pipeline/lab/photographs/calibration_periods.hpp"

#include <algorithm>
#include <string_view>

#include "base/utc_text.hpp"

namespace kasumi {
namespace {

std::optional<Utc> day_or_time(const std::string& text) {
  constexpr std::size_t kDay = 10;
  return parse_utc(text.size() == kDay ? text + "T00:00:00Z" : text);
}

}  // namespace

Result<CalibrationPeriods> CalibrationPeriods::read(const std::vector<std::string>& given) {
  CalibrationPeriods all;
  Problems problems;
  for (const auto& words : given) {
    const auto dots = words.find(".."), equals = words.find('=', dots == std::string::npos ? 0 : dots);
    const bool whole = dots != std::string::npos && equals != std::string::npos && equals + 1 < words.size();
    const auto first = whole ? words.substr(0, dots) : "",
               last = whole ? words.substr(dots + 2, equals - dots - 2) : "";
    const auto from = first.empty() ? std::optional(Utc::min()) : day_or_time(first);
    const auto to = last.empty() ? std::optional(Utc::max()) : day_or_time(last);
    if (!whole || !from || !to || *from >= *to)
      problems.add(
          "--camera {}: expected FROM..TO=FILE like 2018-03-01..2019-05-01=old.toml, days or times of UTC, "
          "the second later than the first and not part of it, either of them left out at an end",
          words);
    else
      all.periods_.push_back({*from, *to, words.substr(0, equals), words.substr(equals + 1)});
  }
  std::ranges::sort(all.periods_, {}, &Period::from);
  for (std::size_t i = 1; i < all.periods_.size(); ++i) {
    const auto& before = all.periods_[i - 1];
    const auto& after = all.periods_[i];
    if (before.to != after.from)
      problems.add("--camera {} and {}: {}, expected each to begin when the one before ends", before.words, after.words,
                   before.to < after.from ? "leave a gap" : "overlap");
  }
  if (!problems.empty()) return fail(problems.fault());
  return all;
}

std::optional<std::size_t> CalibrationPeriods::at(Utc utc) const {
  for (std::size_t i = 0; i < periods_.size(); ++i)
    if (utc >= periods_[i].from && utc < periods_[i].to) return i;
  return std::nullopt;
}

}  // namespace kasumi
