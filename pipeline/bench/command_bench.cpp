#include <cstdio>
#include <memory>

#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include "gles/display/display_listing.hpp"
#include "pipeline/bench/bench.hpp"
#include "pipeline/bench/gles.hpp"
#include "pipeline/bench/haze.hpp"
#include "pipeline/command.hpp"

namespace kasumi {

namespace {

std::string goal_of(const BenchRow& row) {
  return row.goal ? fmt::format("{} {:g}", row.at_most ? "<=" : ">=", *row.goal) : std::string();
}

void print(const std::vector<BenchRow>& rows, bool markdown) {
  for (const auto& row : rows) {
    const auto reached = !row.goal ? "" : row.reached() ? "reached" : "MISSED";
    if (markdown)
      fmt::print("| {} | {:.3g}{} | {}{} |\n", row.name.starts_with("  ") ? "... " + row.name.substr(2) : row.name,
                 row.value, row.unit == "x" ? "" : " " + row.unit, goal_of(row), row.reached() ? "" : ": **missed**");
    else
      fmt::print("{:<72} {:>10.4g} {:<10} {:<10} {}\n", row.name, row.value, row.unit, goal_of(row), reached);
    std::fflush(stdout);
  }
}

// Whether the kiosk's pictures need the GPU at all on this machine's displays.
void print_planes() {
  const auto cards = list_displays();
  if (cards.empty()) fmt::print("planes: no graphics card with a display: the GPU composes each picture\n");
  for (const auto& card : cards) {
    if (!card.plane_formats.empty())
      fmt::print("planes: {} ({}) lays the building over pictures in {} by itself\n", card.path, card.driver,
                 fmt::join(card.plane_formats, ", "));
    else
      fmt::print("planes: {} ({}): the GPU composes each picture: {}\n", card.path, card.driver,
                 !card.problem.empty()     ? card.problem
                 : !card.no_planes.empty() ? card.no_planes
                                           : "no display is connected");
  }
}

// Every part in turn; the first that cannot be measured ends it.
Result<int> measure(bool markdown) {
  if (markdown)
    fmt::print("| | measured | goal |\n|---|---|---|\n");
  else
    fmt::print("{:<72} {:>10} {:<10} {:<10}\n", "", "measured", "", "goal");
  print(bench_turbidity(), markdown);
  print(bench_sky_answer(), markdown);
  print(bench_air(), markdown);
  for (const auto part : {+[] { return bench_gles(); }, +[] { return bench_layer(); }, +[] { return bench_dome(); },
                          +[] { return bench_haze(); }}) {
    const auto rows = part();
    if (!rows) return fail(rows.error());
    print(*rows, markdown);
  }
  if (!markdown) print_planes();
  return 0;
}

}  // namespace

void add_bench_command(CLI::App& app, Action& action) {
  auto* command = app.add_subcommand("bench", "Cost of each part, as ratios of alternate measurements");
  auto markdown = std::make_shared<bool>(false);
  command->add_flag("--markdown", *markdown, "As a table of Markdown, as docs/performance.md has it");
  command->callback([&action, markdown] { action = [markdown] { return measure(*markdown); }; });
}

}  // namespace kasumi
