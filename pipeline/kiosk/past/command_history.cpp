#include <cstdio>
#include <ctime>
#include <memory>

#include <CLI/CLI.hpp>

#include "base/files.hpp"
#include "base/utc_text.hpp"
#include "history/history_plot.hpp"
#include "history/history_ring.hpp"
#include "pipeline/command.hpp"

namespace kasumi {
namespace {

using std::chrono::minutes;

constexpr minutes kWeek{7 * 24 * 60};

struct HistoryArguments {
  std::string file = "/var/lib/kasumi/history.txt", since, plot;
  bool csv = false;
};

std::tm wall_clock(UtcMinute at) {
  const auto seconds = static_cast<std::time_t>(std::chrono::seconds(at.time_since_epoch()).count());
  std::tm wall{};
  ::localtime_r(&seconds, &wall);
  return wall;
}

minutes ahead_of_utc(UtcMinute at) {
  return minutes{wall_clock(at).tm_gmtoff / 60};
}

std::string wall_text(UtcMinute at) {
  const auto wall = wall_clock(at);
  return fmt::format("{:04}-{:02}-{:02} {:02}:{:02}", wall.tm_year + 1900, wall.tm_mon + 1, wall.tm_mday, wall.tm_hour,
                     wall.tm_min);
}

// "14:10" is the last one by the wall clock; "2026-06-21T14:10:00Z"; "3h", "2d": so long ago.
Result<UtcMinute> parse_since(const std::string& text, UtcMinute now) {
  if (const auto utc = parse_utc(text)) return std::chrono::floor<minutes>(*utc);
  int hour = 0, minute = 0, taken = 0;
  if (std::sscanf(text.c_str(), "%2d:%2d%n", &hour, &minute, &taken) == 2 && taken == static_cast<int>(text.size()) &&
      hour >= 0 && hour < 24 && minute >= 0 && minute < 60) {
    auto wall = wall_clock(now);
    wall.tm_hour = hour;
    wall.tm_min = minute;
    wall.tm_sec = 0;
    wall.tm_isdst = -1;
    const UtcMinute at(std::chrono::floor<minutes>(std::chrono::seconds(std::mktime(&wall))));
    return at <= now ? at : at - minutes{24 * 60};
  }
  int count = 0;
  char unit = 0;
  if (std::sscanf(text.c_str(), "%5d%c%n", &count, &unit, &taken) == 2 && taken == static_cast<int>(text.size()) &&
      count > 0 && (unit == 'h' || unit == 'd'))
    return now - minutes{count} * (unit == 'h' ? 60 : 24 * 60);
  return fail(FaultKind::bad_input,
              "--since {}: expected a time like 14:10, a time ago like 3h or 2d, or 2026-06-21T12:10:00Z", text);
}

std::string spells_text(const std::vector<HistoryLine>& lines) {
  std::string text;
  for (const auto& spell : spells_of(lines)) {
    text += fmt::format("{} - {}  {:<26}", wall_text(spell.from), wall_text(spell.to).substr(11), spell_state(spell));
    if (spell.turbidity) text += fmt::format("  T {:.2f}", *spell.turbidity);
    if (spell.aod_550) text += fmt::format("  AOD {:.3f}", *spell.aod_550);
    if (spell.celsius) text += fmt::format("  {:.0f} °C", *spell.celsius);
    text.erase(text.find_last_not_of(' ') + 1);
    text += '\n';
  }
  return text;
}

Result<int> tell_history(const HistoryArguments& arguments) {
  auto lines = read_history(arguments.file);
  if (!lines) return fail(lines.error());
  const auto now = std::chrono::floor<minutes>(std::chrono::system_clock::now());
  auto from = now - kWeek;
  if (!arguments.since.empty()) {
    const auto since = parse_since(arguments.since, now);
    if (!since) return fail(since.error());
    from = *since;
    std::erase_if(*lines, [&](const HistoryLine& line) { return line.utc < from; });
  } else if (!lines->empty()) {
    from = lines->front().utc;
  }
  if (lines->empty()) return fail(FaultKind::io, "{}: no minute since {}", arguments.file, utc_text(from));
  if (arguments.csv) fmt::print("{}", history_csv(*lines));
  if (!arguments.csv && arguments.plot.empty()) fmt::print("{}", spells_text(*lines));
  if (arguments.plot.empty()) return 0;
  const auto to = std::max(lines->back().utc, from) + minutes{1};
  const auto drawn = history_plot(*lines, from, to, ahead_of_utc(to));
  if (auto written = write_text_file(arguments.plot, drawn); !written) return fail(written.error());
  return 0;
}

}  // namespace

void add_history_command(CLI::App& app, Action& action) {
  auto* command = app.add_subcommand("history", "What was when: the last week of the kiosk, a line a minute");
  auto arguments = std::make_shared<HistoryArguments>();
  command->add_option("--file", arguments->file, "The history, in the folder of [state]")->capture_default_str();
  command->add_option("--since", arguments->since, "Only from then on: 14:10, 3h, 2d or 2026-06-21T12:10:00Z");
  command->add_flag("--csv", arguments->csv, "Every minute as a table, instead of spells of one state");
  command->add_option("--plot", arguments->plot, "SVG to write: what visitors saw, T and optical depth with sigma");
  command->callback([arguments, &action] { action = [arguments] { return tell_history(*arguments); }; });
}

}  // namespace kasumi
