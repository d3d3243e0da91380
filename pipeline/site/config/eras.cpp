#include "pipeline/site/config/eras.hpp"

#include <algorithm>
#include <array>
#include <bitset>
#include <set>

#include <fmt/ranges.h>

namespace kasumi {

namespace {

using namespace std::chrono_literals;
using std::chrono::days;
using std::chrono::minutes;

constexpr std::size_t kMostEras = 24;
constexpr std::size_t kMinutesOfDay = 24 * 60;
constexpr int kMostTold = 6;  // times at which eras overlap or are missing

using Together = std::bitset<kMostEras>;                // of eras
using DayOfEras = std::array<Together, kMinutesOfDay>;  // which are shown in each minute

std::size_t index_of(minutes time) {
  return static_cast<std::size_t>(std::clamp<std::int64_t>(time.count(), 0, kMinutesOfDay));
}

// The parts of a day that hours cover which begin on it, and those that begin on the day before.
template <class Minutes, class Mark>
void mark_hours(const DayHours& hours, bool today, Minutes& day, Mark mark) {
  const minutes shift = today ? 0min : -24h;
  for (const auto& span : hours)
    for (auto i = index_of(span.from + shift); i < index_of(span.until + shift); ++i) mark(day[i]);
}

// Minutes of a day at which the kiosk is open on any day at all.
std::bitset<kMinutesOfDay> possibly_open(const OpeningHours& opening) {
  std::array<bool, kMinutesOfDay> open{};
  const auto add = [&](const DayHours& hours) {
    for (const bool today : {true, false}) mark_hours(hours, today, open, [](bool& minute) { minute = true; });
  };
  for (const auto& hours : opening.week) add(hours);
  for (const auto& exception : opening.exceptions) add(exception.hours);
  std::bitset<kMinutesOfDay> found;
  for (std::size_t i = 0; i < open.size(); ++i) found[i] = open[i];
  return found;
}

std::string date_text(std::chrono::sys_days day) {
  const std::chrono::year_month_day date(day);
  return fmt::format("{:02}-{:02}", static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()));
}

// The minutes of a day for which `wrong` holds: "09:00-12:00, 15:00-17:00"; empty: none.
template <class Wrong>
std::string spans_text(Wrong wrong) {
  std::string text;
  for (std::size_t i = 0; i < kMinutesOfDay; ++i) {
    if (!wrong(i)) continue;
    const auto from = i;
    while (i < kMinutesOfDay && wrong(i)) ++i;
    text += fmt::format("{}{:02}:{:02}-{:02}:{:02}", text.empty() ? "" : ", ", from / 60, from % 60, i / 60, i % 60);
  }
  return text;
}

// Days in a row on which the same is wrong.
class Run {
 public:
  // Returns the run that ends because something else holds on this day: "02-28..02-29, 09:00-12:00"; empty: none.
  std::string next(std::chrono::sys_days day, std::string spans) {
    std::string ended;
    if (spans == spans_) {
      last_ = day;
      return ended;
    }
    if (!spans_.empty())
      ended = fmt::format("{}{}, {}", date_text(first_), first_ == last_ ? "" : ".." + date_text(last_), spans_);
    first_ = last_ = day;
    spans_ = std::move(spans);
    return ended;
  }

 private:
  std::chrono::sys_days first_{}, last_{};
  std::string spans_;
};

// A whole year, with its 29th of February.
class Year {
 public:
  explicit Year(const std::vector<Era>& eras) : eras_(eras) {}
  static constexpr std::chrono::sys_days kFirst = std::chrono::sys_days{std::chrono::year(2028) / 1 / 1};
  static constexpr days kLength{366};

  Together on(std::chrono::sys_days day) const {
    Together found;
    for (std::size_t era = 0; era < eras_.size(); ++era)
      found[era] =
          !eras_[era].otherwise && !eras_[era].visitors_only && eras_[era].includes(std::chrono::year_month_day(day));
    return found;
  }

  DayOfEras minutes_of(Together today, Together yesterday) const {
    DayOfEras day{};
    for (std::size_t era = 0; era < eras_.size(); ++era) {
      const auto mark = [&](Together& minute) { minute.set(era); };
      if (today[era]) mark_hours(eras_[era].hours, true, day, mark);
      if (yesterday[era]) mark_hours(eras_[era].hours, false, day, mark);
    }
    return day;
  }

  // `wrong` says of each kind of day at which times something is wrong ("" never), `tell` is called with all such
  // times.
  template <class Wrong, class Tell>
  void look_for(Wrong wrong, Tell tell) const {
    Run run;
    std::string spans;
    std::optional<std::pair<Together, Together>> before;
    int told = 0;
    const auto hear = [&](const std::string& times) {
      if (!times.empty() && ++told <= kMostTold) tell(times);
    };
    for (auto day = kFirst; day < kFirst + kLength; day += days(1)) {
      const std::pair kind{on(day), on(day - days(1))};
      if (kind != before) spans = wrong(minutes_of(kind.first, kind.second));
      before = kind;
      hear(run.next(day, spans));
    }
    hear(run.next(kFirst + kLength, {}));
  }

 private:
  const std::vector<Era>& eras_;
};

const char* when_key(const ConfigTable& table) {
  return table.has("dates") || !table.has("hours") ? "dates" : "hours";
}

void refuse_overlaps(const std::vector<Era>& eras, const std::vector<ConfigTable>& tables, const Year& year) {
  for (std::size_t later = 1; later < eras.size(); ++later)
    for (std::size_t earlier = 0; earlier < later; ++earlier)
      year.look_for(
          [&](const DayOfEras& day) {
            return spans_text([&](std::size_t i) { return day[i][later] && day[i][earlier]; });
          },
          [&](const std::string& times) {
            tables[later].problem(when_key(tables[later]),
                                  fmt::format("one era at a time, but \"{}\" and \"{}\" are both shown on {}",
                                              eras[earlier].name, eras[later].name, times));
          });
}

void refuse_gaps(const std::vector<Era>& eras, const ConfigTable& root, const OpeningHours& opening, const Year& year) {
  if (std::ranges::any_of(eras, &Era::otherwise)) return;
  const auto open = possibly_open(opening);
  year.look_for(
      [&](const DayOfEras& day) { return spans_text([&](std::size_t i) { return open[i] && day[i].none(); }); },
      [&](const std::string& times) {
        root.problem("era", fmt::format("an era for every time at which the kiosk may be open, but none is shown on {}"
                                        " (one with neither dates nor hours is shown for the rest of the time)",
                                        times));
      });
}

Era read_era(const ConfigTable& table) {
  Era era;
  era.name = table.text("name");
  if (table.has("name") && era.name.empty()) table.problem("name", "a name");
  era.visitors_only = table.flag("visitors_only", false);
  const bool always = !table.has("dates") && !table.has("hours");
  if (era.visitors_only && !always)
    table.problem("visitors_only", "false in an era with dates or hours: with true it has neither");
  era.otherwise = always && !era.visitors_only;
  if (table.has("dates")) {
    if (auto dates = parse_yearly(table.text("dates")))
      era.dates = std::move(*dates);
    else
      table.problem("dates", dates.error().message);
  }
  if (table.has("hours")) {
    if (auto hours = parse_hours(table.text("hours")); hours && !hours->empty())
      era.hours = std::move(*hours);
    else
      table.problem("hours", hours ? "hours like \"09:00-12:00\"" : hours.error().message);
  }
  era.model = table.optional_file("model");
  if (table.has("scene")) era.scene = table.text("scene");
  era.picture = table.optional_file("picture");
  if (table.has("caption")) era.caption = table.text("caption");
  return era;
}

bool begins_on(const Era& era, std::chrono::local_days day) {
  return !era.otherwise && !era.visitors_only && era.includes(std::chrono::year_month_day(day));
}

}  // namespace

bool Era::includes(std::chrono::year_month_day day) const {
  return dates.empty() || std::ranges::any_of(dates, [&](const YearlyDates& range) { return range.includes(day); });
}

std::vector<Era> read_eras(const ConfigTable& root, const OpeningHours& opening) {
  std::vector<Era> eras;
  const auto tables = root.tables("era");
  if (tables.size() > kMostEras) {
    root.problem("era", fmt::format("at most {} eras", kMostEras));
    for (const auto& table : tables)
      for (const auto& key : table.keys()) table.ignore(key);
    return eras;
  }
  std::set<std::string> names;
  bool rest_taken = false;
  for (const auto& table : tables) {
    eras.push_back(read_era(table));
    const auto& era = eras.back();
    if (!era.name.empty() && !names.insert(era.name).second) table.problem("name", "a name that no other era has");
    if (era.otherwise && rest_taken)
      table.problem("dates", "dates or hours: another era without them is shown for the rest of the time already");
    rest_taken = rest_taken || era.otherwise;
  }
  if (eras.empty()) return eras;
  const Year year(eras);
  refuse_overlaps(eras, tables, year);
  refuse_gaps(eras, root, opening, year);
  return eras;
}

std::optional<std::size_t> era_at(const std::vector<Era>& eras, const std::string& time_zone, Utc now) {
  if (eras.empty()) return std::nullopt;
  const auto local = local_time(time_zone, now);
  const auto today = std::chrono::floor<days>(local);
  for (const auto day : {today, today - days(1)})
    for (std::size_t i = 0; i < eras.size(); ++i)
      for (const auto& span : eras[i].hours)
        if (begins_on(eras[i], day) && local - day >= span.from && local - day < span.until) return i;
  for (std::size_t i = 0; i < eras.size(); ++i)
    if (eras[i].otherwise) return i;
  std::optional<std::size_t> next;
  std::chrono::local_time<Duration> begins{};
  for (auto day = today; !next && day <= today + days(366); day += days(1))
    for (std::size_t i = 0; i < eras.size(); ++i)
      for (const auto& span : eras[i].hours) {
        const auto at = day + span.from;
        if (!begins_on(eras[i], day) || at < local || (next && at >= begins)) continue;
        next = i;
        begins = at;
      }
  return next.value_or(0);
}

}  // namespace kasumi
